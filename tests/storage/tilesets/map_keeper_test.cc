#include "storage/tilesets/map_keeper.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "storage/tilesets/map_files.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

TEST(MapKeeper, GoesOnFromWhatAKilledRunLeftIfItsTilesAreWhole) {
  const test::TemporaryFolder folder;
  const fs::path killed = folder / "killed", whole = folder / "whole", damaged = folder / "damaged";
  for (const fs::path& each : {killed, whole, damaged}) fs::create_directory(each);
  const geo::TileId block = *geo::TileId::Make(5, 3, 7);
  Digest digest{};
  digest[0] = 1;
  {
    const auto keeper = *MapKeeper::Create(killed, {});
    ASSERT_TRUE(keeper->Put(block, image::PictureFormat::kJpeg, std::vector<std::uint8_t>(20'000, 0x5a)));
    pyramid::KeptBlock kept;
    kept.tiles = kept.base_tiles = 1;
    ASSERT_TRUE(keeper->Keep(block, digest, kept));
    ASSERT_TRUE(keeper->Remember("facts"));  // and so committed
    for (const fs::path& each : {whole, damaged}) fs::copy(killed, each);
  }
  {
    const auto keeper = *MapKeeper::Create(whole, {});
    EXPECT_EQ(keeper->DigestOf(block), digest);
    EXPECT_EQ(keeper->Recall(), "facts");
  }
  // Pages that a power cut kept from the disk are full of zeros.
  ASSERT_TRUE(SqliteDb::Open(TemporaryMap(damaged).tiles, OpenMode::kReadWrite)
                  ->Exec("UPDATE tiles_data SET tile_data=zeroblob(length(tile_data))"));
  const auto keeper = *MapKeeper::Create(damaged, {});
  EXPECT_FALSE(keeper->DigestOf(block));
  EXPECT_EQ(keeper->Recall(), "");
}

}  // namespace
}  // namespace skyquilt::storage
