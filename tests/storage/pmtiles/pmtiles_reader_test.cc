// Tiles by ranges are those of the MBTiles from which the archive was made, at no more reads than promised.
#include "storage/pmtiles/pmtiles_reader.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "core/base/progress.h"
#include "core/base/try.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/blobs/range_cache.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

// A folder that is as far away as S3: what is read of it is counted, and ranges are kept in a cache.
class FarBlobs final : public BlobStore {
 public:
  explicit FarBlobs(const std::filesystem::path& root)
      : near_(root),
        cache_(*LocalCache::Open(root / "cache", std::int64_t{1} << 30)),
        ranges_(
            *cache_,
            [this](const std::string& key, std::int64_t offset, std::int64_t length) {
              ++reads;
              Result<std::string> bytes = near_.ReadRange(key, offset, length);
              if (bytes && harm) harm(*bytes);
              return bytes;
            },
            [this](const std::string& key) -> Result<std::shared_ptr<const std::string>> {
              if (!has_sums) return std::shared_ptr<const std::string>();
              SKYQUILT_TRY_ASSIGN(std::string sums, RangeSumsOfFile(near_.FolderOf(key)));
              return std::make_shared<const std::string>(std::move(sums));
            }) {}
  void DoubtNear(const std::string& key) override {
    if (!has_sums) ranges_.Forget(key);
  }
  Result<void> Put(const std::string& key, const std::filesystem::path& file) override {
    return near_.Put(key, file);
  }
  Result<void> PutIfAbsent(const std::string& key, std::string_view bytes) override {
    return near_.PutIfAbsent(key, bytes);
  }
  Result<std::string> ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) override {
    ++reads;
    return near_.ReadRange(key, offset, length);
  }
  Result<std::string> ReadNear(const std::string& key, std::int64_t offset, std::int64_t length) override {
    return ranges_.Get(key, offset, length);
  }
  Result<BlobInfo> Find(const std::string& key) override { return near_.Find(key); }
  Result<std::vector<BlobInfo>> List(const std::string& prefix) override { return near_.List(prefix); }
  Result<void> Remove(const std::string& key) override { return near_.Remove(key); }
  Result<void> Copy(const std::string& from, const std::string& to) override { return near_.Copy(from, to); }
  Result<int> RemoveBelow(const std::string& prefix) override { return near_.RemoveBelow(prefix); }
  Result<LocalBlob> Local(const std::string& key) override { return near_.Local(key); }
  bool IsFolder() const override { return false; }
  std::filesystem::path FolderOf(const std::string& prefix) const override { return near_.FolderOf(prefix); }
  std::string Address() const override { return near_.Address(); }

  int reads = 0;
  bool has_sums = true;
  std::function<void(std::string&)> harm;  // done to what is read

 private:
  FolderBlobs near_;
  std::unique_ptr<LocalCache> cache_;
  RangeCache ranges_;
};

constexpr const char* kKey = "flights/a/r1/mosaic.pmtiles";

class PmtilesOfPaintedMap : public testing::Test {
 protected:
  void Make(const test::PaintedTileset& tileset) {
    std::filesystem::create_directories(folder_ / "flights/a/r1");
    test::WritePaintedTileset(folder_ / "map.mbtiles", tileset);
    SilentProgress progress;
    ASSERT_TRUE(WritePmtiles(folder_ / "map.mbtiles", folder_ / kKey, progress));
    mbtiles_ = *MbtilesReader::Open(folder_ / "map.mbtiles");
  }
  // One of several chunks, 40 x 40 tiles, which takes its time: made once.
  void MakeLarge() {
    static const test::TemporaryFolder made;
    if (!std::filesystem::exists(made / "map.pmtiles")) {
      Make({.zoom = 18, .first_column = 140'000, .first_row = 84'000, .columns = 40, .rows = 40});
      std::filesystem::copy_file(folder_ / "map.mbtiles", made / "map.mbtiles");
      std::filesystem::copy_file(folder_ / kKey, made / "map.pmtiles");
      return;
    }
    std::filesystem::create_directories(folder_ / "flights/a/r1");
    std::filesystem::copy_file(made / "map.mbtiles", folder_ / "map.mbtiles");
    std::filesystem::copy_file(made / "map.pmtiles", folder_ / kKey);
    mbtiles_ = *MbtilesReader::Open(folder_ / "map.mbtiles");
  }
  test::TemporaryFolder folder_;
  std::shared_ptr<FarBlobs> blobs_ = std::make_shared<FarBlobs>(folder_.path());
  std::shared_ptr<MbtilesReader> mbtiles_;
};

TEST_F(PmtilesOfPaintedMap, HasTheSameTilesUnderTheSameTags) {
  Make({.zoom = 16, .first_column = 35'000, .first_row = 21'000, .columns = 12, .rows = 9});
  const auto reader = *PmtilesReader::Open(blobs_, kKey, std::make_shared<PmtilesMemory>());
  int tiles = 0;
  for (int zoom = 10; zoom <= 17; ++zoom) {
    const int shift = 16 - zoom;
    const auto scaled = [&](int at) { return shift >= 0 ? at >> shift : at << -shift; };
    for (int x = scaled(35'000) - 1; x <= scaled(35'012) + 1; ++x) {
      for (int y = scaled(21'000) - 1; y <= scaled(21'009) + 1; ++y) {
        const geo::TileId tile = *geo::TileId::Make(zoom, x, y);
        const auto here = *mbtiles_->Find(tile);
        const auto there = test::ValueOf(reader->Find(tile));
        ASSERT_EQ(here.has_value(), there.has_value()) << zoom << "/" << x << "/" << y;
        if (!here) continue;
        EXPECT_EQ(here->content_id, there->content_id);
        EXPECT_EQ(*mbtiles_->Load(*here), *reader->Load(*there));
        ++tiles;
      }
    }
  }
  EXPECT_GT(tiles, 60);
  for (const char* name : {"name", "format", "tile_size", "minzoom", "maxzoom"}) {
    EXPECT_EQ(reader->metadata().at(name), mbtiles_->metadata().at(name)) << name;
  }
}

TEST_F(PmtilesOfPaintedMap, TakesOneReadForWhatIsColdAndNoneForWhatLiesNear) {
  MakeLarge();
  const auto size = std::filesystem::file_size(folder_ / kKey);
  ASSERT_GT(size, 4U * kRangeChunkBytes) << "the map is too small for this test";
  const auto reader = *PmtilesReader::Open(blobs_, kKey, std::make_shared<PmtilesMemory>());
  EXPECT_EQ(blobs_->reads, 1);
  const int opened = blobs_->reads;
  int most = 0, tiles = 0;
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) {
      const int before = blobs_->reads;
      const auto found = *reader->Find(*geo::TileId::Make(18, 140'000 + x, 84'000 + y));
      if (!found) continue;
      ++tiles;
      most = std::max(most, blobs_->reads - before);
      const int first = blobs_->reads;
      ASSERT_TRUE(reader->IsAtHand(*geo::TileId::Make(18, 140'000 + x, 84'000 + y)));
      ASSERT_TRUE(reader->Find(*geo::TileId::Make(18, 140'000 + x, 84'000 + y)));
      EXPECT_EQ(blobs_->reads, first);
    }
  }
  EXPECT_EQ(most, 1);
  EXPECT_LE(blobs_->reads - opened, static_cast<int>(size / kRangeChunkBytes) + 1);
  EXPECT_GT(tiles, 4 * (blobs_->reads - opened));
}

TEST_F(PmtilesOfPaintedMap, KeepsNothingOfWhatAStoreGaveWrong) {
  MakeLarge();
  int harmed = 0;
  // Every second answer: a flipped byte, one too short, one that is empty.
  blobs_->harm = [&](std::string& bytes) {
    if (blobs_->reads % 2 == 0 || bytes.empty()) return;
    const int kind = harmed++ % 3;
    if (kind == 0) bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    if (kind == 1) bytes.resize(bytes.size() / 2);
    if (kind == 2) bytes.clear();
  };
  const auto reader = test::ValueOf(PmtilesReader::Open(blobs_, kKey, std::make_shared<PmtilesMemory>()));
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) {
      const geo::TileId tile = *geo::TileId::Make(18, 140'000 + x, 84'000 + y);
      const auto here = *mbtiles_->Find(tile);
      const auto there = test::ValueOf(reader->Find(tile));
      ASSERT_EQ(here.has_value(), there.has_value());
      if (!here) continue;
      ASSERT_EQ(here->content_id, there->content_id);
    }
  }
  EXPECT_GT(harmed, 3);
}

TEST_F(PmtilesOfPaintedMap, ComesBackWithAStoreThatWasWrongForAWhile) {
  Make({.zoom = 16, .first_column = 35'000, .first_row = 21'000, .columns = 4, .rows = 4});
  // Of a map without sums, damage to the packed directory is seen by itself.
  for (const bool has_sums : {true, false}) {
    blobs_->has_sums = has_sums;
    blobs_->harm = [](std::string& bytes) { bytes[140] = static_cast<char>(bytes[140] ^ 1); };
    EXPECT_EQ(test::ErrorOf(PmtilesReader::Open(blobs_, kKey, std::make_shared<PmtilesMemory>())).code,
              ErrorCode::kUnavailable);
    blobs_->harm = nullptr;
    const auto well = test::ValueOf(PmtilesReader::Open(blobs_, kKey, std::make_shared<PmtilesMemory>()));
    EXPECT_TRUE(well->Find(*geo::TileId::Make(16, 35'002, 21'002))->has_value());
    std::filesystem::remove_all(folder_ / "cache");
    blobs_ = std::make_shared<FarBlobs>(folder_.path());
  }
}

// More entries than a root can have: a cold tile takes its leaf and itself.
TEST_F(PmtilesOfPaintedMap, TakesTwoReadsWhereThereAreLeaves) {
  std::filesystem::create_directories(folder_ / "flights/a/r1");
  {
    auto writer = *MbtilesWriter::Create(folder_ / "map.mbtiles");
    for (int x = 0; x < 256; ++x) {
      for (int y = 0; y < 256; ++y) {
        const std::string bytes = "\xff\xd8tile " + std::to_string(1'000 * x + y) +
                                  std::string(static_cast<std::size_t>((x * y) % 90), 'x');
        ASSERT_TRUE(writer->Put(*geo::TileId::Make(12, x, y), image::PictureFormat::kJpeg,
                                {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
      }
    }
    TilesetMetadata metadata;
    metadata.name = "many";
    metadata.min_zoom = metadata.max_zoom = 12;
    ASSERT_TRUE(writer->Publish(metadata));
  }
  SilentProgress progress;
  ASSERT_TRUE(WritePmtiles(folder_ / "map.mbtiles", folder_ / kKey, progress));
  mbtiles_ = *MbtilesReader::Open(folder_ / "map.mbtiles");
  const auto memory = std::make_shared<PmtilesMemory>(std::size_t{300} << 10, std::size_t{10} << 10);
  const auto reader = *PmtilesReader::Open(blobs_, kKey, memory);
  int most = 0;
  for (int x = 0; x < 256; x += 5) {
    for (int y = 0; y < 256; y += 7) {
      const geo::TileId tile = *geo::TileId::Make(12, x, y);
      const int before = blobs_->reads;
      const bool is_at_hand = reader->IsAtHand(tile);
      EXPECT_EQ(blobs_->reads, before);
      const auto found = test::ValueOf(*reader->Find(tile));
      EXPECT_FALSE(is_at_hand);
      most = std::max(most, blobs_->reads - before);
      EXPECT_EQ(*found.bytes, *mbtiles_->Load(**mbtiles_->Find(tile)));
    }
  }
  EXPECT_LE(most, 2);
  EXPECT_LE(memory->leaves.bytes(), (std::size_t{300} << 10) + 4096 * sizeof(PmtilesEntry));
  EXPECT_LE(memory->tiles.bytes(), std::size_t{11} << 10);
}

TEST_F(PmtilesOfPaintedMap, SaysWhereAnArchiveIsDamagedWhereverThatIs) {
  Make({.zoom = 16, .first_column = 35'000, .first_row = 21'000, .columns = 4, .rows = 4});
  const std::string whole = test::BytesOf(folder_ / kKey);
  const geo::TileId tile = *geo::TileId::Make(16, 35'002, 21'002);
  int refused = 0;
  for (std::size_t at = 0; at < 1'500; ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    const std::string key = "flights/a/r1/d" + std::to_string(at);
    std::ofstream(folder_ / key, std::ios::binary) << damaged;
    const auto reader = PmtilesReader::Open(blobs_, key, std::make_shared<PmtilesMemory>());
    if (!reader || !(*reader)->Find(tile)) ++refused;
    std::filesystem::remove(folder_ / key);
  }
  EXPECT_GT(refused, 150);
  for (const std::size_t left : {0U, 5U, 127U, 200U, 2'000U}) {
    const std::string key = "flights/a/r1/c" + std::to_string(left);
    std::ofstream(folder_ / key, std::ios::binary) << whole.substr(0, left);
    const auto reader = PmtilesReader::Open(blobs_, key, std::make_shared<PmtilesMemory>());
    const bool is_refused = !reader || !(*reader)->Find(tile);
    EXPECT_TRUE(is_refused) << left;
  }
}

}  // namespace
}  // namespace skyquilt::storage
