#include "storage/tilesets/mbtiles_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/pyramid/encode_tile.h"
#include "storage/caches/tileset_cache.h"
#include "storage/db/ids.h"
#include "storage/db/sqlite_db.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

geo::TileId Tile(int z, int x, int y) { return *geo::TileId::Make(z, x, y); }

class EverySchema : public testing::TestWithParam<TilesetSchema> {};

TEST_P(EverySchema, FindsTilesBytesAndGaps) {
  test::TemporaryFolder dir;
  const auto path = dir.path() / "a.mbtiles";
  // z 2: rows count from the south in the file, from the north in our ids.
  WriteSmallTileset(path, GetParam(), {{2, 1, 0, "south"}, {2, 1, 3, "north"}, {2, 2, 3, "north"}});
  const auto reader = MbtilesReader::Open(path);
  ASSERT_TRUE(reader) << reader.error().detail;
  const auto north = (*reader)->Find(Tile(2, 1, 0));
  ASSERT_TRUE(north && north->has_value());
  EXPECT_EQ(*(*reader)->Load(**north), "north");
  const auto south = (*reader)->Find(Tile(2, 1, 3));
  EXPECT_EQ(*(*reader)->Load(**south), "south");
  EXPECT_NE((*south)->content_id, (*north)->content_id);
  EXPECT_EQ((**(*reader)->Find(Tile(2, 2, 0))).content_id, (*north)->content_id);
  EXPECT_FALSE((*reader)->Find(Tile(2, 0, 0))->has_value());
  EXPECT_EQ((*reader)->metadata().at("name"), "small");
}

TEST_P(EverySchema, ReadsNothingThatIsLargerThanAnyTile) {
  test::TemporaryFolder dir;
  const auto path = dir.path() / "a.mbtiles";
  WriteSmallTileset(path, GetParam(), {{2, 1, 0, std::string(kMaxTileBytes + 1, 'a')}, {2, 1, 3, "north"}});
  const auto reader = *MbtilesReader::Open(path);
  const auto large = reader->Find(Tile(2, 1, 3));
  EXPECT_EQ((large ? reader->Load(**large).error() : large.error()).code, ErrorCode::kCorrupt);
  EXPECT_EQ(*reader->Load(**reader->Find(Tile(2, 1, 0))), "north");
}

TEST_P(EverySchema, RefusesMetadataWithoutEnd) {
  test::TemporaryFolder dir;
  const auto path = dir.path() / "a.mbtiles";
  WriteSmallTileset(path, GetParam(), {{2, 1, 0, "south"}});
  ASSERT_TRUE(SqliteDb::Open(path, OpenMode::kReadWriteCreate)
                  ->Exec("INSERT INTO metadata VALUES('attribution', hex(zeroblob(3000000)))"));
  EXPECT_EQ(MbtilesReader::Open(path).error().code, ErrorCode::kCorrupt);
}

INSTANTIATE_TEST_SUITE_P(MbtilesReader, EverySchema,
                         testing::Values(TilesetSchema::kFlat, TilesetSchema::kIntegerKeys,
                                         TilesetSchema::kTextKeys));

TEST(MbtilesReader, FindsWithoutBytesWhereKeysAreIntegers) {
  test::TemporaryFolder dir;
  WriteSmallTileset(dir.path() / "a.mbtiles", TilesetSchema::kIntegerKeys, {{1, 0, 0, "x"}});
  const auto reader = *MbtilesReader::Open(dir.path() / "a.mbtiles");
  EXPECT_FALSE((*reader->Find(Tile(1, 0, 1)))->bytes.has_value());
}

TEST(MbtilesReader, SaysThatBytesAreMissingAndGoesOn) {
  test::TemporaryFolder dir;
  const std::string large(20'000, 'a');
  WriteSmallTileset(dir.path() / "a.mbtiles", TilesetSchema::kIntegerKeys,
                    {{1, 0, 0, large}, {1, 1, 0, "b"}});
  const auto reader = *MbtilesReader::Open(dir.path() / "a.mbtiles");
  const FoundTile first = **reader->Find(Tile(1, 0, 1)), second = **reader->Find(Tile(1, 1, 1));
  EXPECT_EQ(*reader->Load(first), large);
  EXPECT_EQ(*reader->Load(second), "b");
  EXPECT_EQ(reader->Load(FoundTile{1, std::nullopt}).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(*reader->Load(second), "b");
  EXPECT_EQ(*reader->Load(first), large);
}

// What the writer says of tiles, and how readers take it.
TEST(EncodingOf, IsWhatTheWriterPut) {
  using image::TileEncoding;
  const auto opaque_of = [](image::RgbaImage tile) {
    for (std::size_t i = 3; i < tile.rgba.size(); i += 4) tile.rgba[i] = 255;
    return tile;
  };
  auto fringe = image::RgbaImage::Transparent(64, 64);
  std::fill_n(fringe.Pixel(5, 5), 4, std::uint8_t{255});
  for (const auto encoding : {TileEncoding::kJpegPng, TileEncoding::kWebp, TileEncoding::kJpegWebp}) {
    for (const bool has_opaque : {false, true}) {
      test::TemporaryFolder dir;
      auto writer = *MbtilesWriter::Create(dir.path() / "a.mbtiles");
      const auto put = [&](int column, const image::RgbaImage& tile) {
        const auto encoded = pyramid::EncodeTile(tile, {encoding, 85});
        ASSERT_TRUE(writer->Put(Tile(4, column, 0), encoded->format, encoded->bytes));
      };
      put(0, fringe);
      if (has_opaque) put(1, opaque_of(fringe));
      ASSERT_TRUE(writer->Publish({}));
      const auto reader = *MbtilesReader::Open(dir.path() / "a.mbtiles");
      const auto& metadata = reader->metadata();
      // Of a fringe alone nobody can tell what the map within would have been: it is as good as JPEG.
      EXPECT_EQ(EncodingOf(metadata),
                has_opaque || encoding != TileEncoding::kWebp ? encoding : TileEncoding::kJpegWebp);
      EXPECT_EQ(metadata.at("format"), encoding == TileEncoding::kJpegPng ? "png" : "webp");
    }
  }
}

TEST(MbtilesReader, RefusesWhatIsNotATileset) {
  test::TemporaryFolder dir;
  {
    ASSERT_TRUE(
        SqliteDb::Open(dir.path() / "a.mbtiles", OpenMode::kReadWriteCreate)->Exec("CREATE TABLE t(a)"));
  }
  EXPECT_EQ(MbtilesReader::Open(dir.path() / "a.mbtiles").error().code, ErrorCode::kCorrupt);
}

TEST(MbtilesReaderConcurrency, ServesManyThreadsTheRightTiles) {
  test::TemporaryFolder dir;
  std::vector<SmallTile> tiles;
  for (int x = 0; x < 16; ++x) tiles.push_back({4, x, x, "tile " + std::to_string(x)});
  WriteSmallTileset(dir.path() / "a.mbtiles", TilesetSchema::kIntegerKeys, tiles);
  const auto reader = *MbtilesReader::Open(dir.path() / "a.mbtiles");
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        const int x = (i * 7 + t) % 16;
        const auto found = reader->Find(Tile(4, x, 15 - x));
        ASSERT_TRUE(found && found->has_value());
        ASSERT_EQ(*reader->Load(**found), "tile " + std::to_string(x));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(TilesetCache, ShowsTheNewRevisionSoonAndLetsOldReadersFinish) {
  test::TemporaryFolder scratch;
  const auto dir = *DataDir::Open(scratch.path());
  const auto db = *CatalogueDb::Open(dir.Catalogue());
  Catalogue catalogue(*db);
  TilesetCache cache(dir, catalogue);
  const std::string flight = catalogue.AddFlight("f", "{}", Now())->id;
  EXPECT_EQ(cache.Get(flight).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(cache.Get(NewId()).error().code, ErrorCode::kNotFound);

  PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "one"}});
  const auto first = *cache.Get(flight);
  EXPECT_EQ(first->revision.revision, 1);
  PublishSmallTileset(dir, *db, flight, {{1, 0, 1, "two"}});
  std::filesystem::remove_all(dir.Revision(flight, 1));
  std::this_thread::sleep_for(TilesetCache::kFreshFor);
  const auto second = *cache.Get(flight);
  EXPECT_EQ(second->revision.revision, 2);
  EXPECT_EQ(*second->reader->Load(**second->reader->Find(Tile(1, 0, 0))), "two");
  EXPECT_EQ(*first->reader->Load(**first->reader->Find(Tile(1, 0, 0))), "one");
}

}  // namespace
}  // namespace skyquilt::storage
