#include "storage/exports/stored_tiles.h"

#include <gtest/gtest.h>

#include "storage/tilesets/mbtiles_writer.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

std::vector<GridLevel> GridOfColumns(std::int64_t first, std::int64_t count, int zoom, int tile_size_px,
                                     GridAlignment alignment) {
  test::TemporaryFolder folder;
  auto writer = *MbtilesWriter::Create(folder.path() / "map.mbtiles");
  const std::vector<std::uint8_t> bytes{1};
  for (int level = 0; level <= zoom; ++level) {
    for (std::int64_t x = first >> level; x <= (first + count - 1) >> level; ++x) {
      EXPECT_TRUE(
          writer->Put(*geo::TileId::Make(zoom - level, x, 5 >> level), image::PictureFormat::kJpeg, bytes));
    }
  }
  EXPECT_TRUE(writer->Publish({}));
  auto db = *SqliteDb::Open(folder.path() / "map.mbtiles", OpenMode::kReadOnlyImmutable);
  return *GridOf(db, tile_size_px, alignment);
}

TEST(TileGrid, HalvesExactlyFromLevelToLevel) {
  for (const std::int64_t first : {0, 1, 127, 128, 500}) {
    for (const std::int64_t count : {1, 2, 3, 9, 300}) {
      const auto grid = GridOfColumns(first, count, 10, 256, GridAlignment::kAllLevels);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        EXPECT_EQ(grid[i].width_px << i, grid[0].width_px);
        EXPECT_EQ(grid[i].first_column << i, grid[0].first_column);
        EXPECT_GE((grid[i].first_column + grid[i].columns) << i, first + count);
        EXPECT_LE(grid[0].first_column, first);
      }
      EXPECT_LE(grid.back().columns, 3);
      // The room added for the alignment stays below the map's own size.
      EXPECT_LT(first - grid[0].first_column, count);
    }
  }
}

TEST(TileGrid, AddsLittleRoomWhereOnlyFineLevelsAreAligned) {
  for (const std::int64_t first : {0, 1, 127, 500}) {
    for (const std::int64_t count : {1, 2, 9, 300}) {
      const auto grid = GridOfColumns(first, count, 10, 256, GridAlignment::kFineLevels);
      EXPECT_TRUE(grid[0].IsAligned());
      // One row of tiles: only the corner's own needs may move it, and those by whole pixels of the coarsest
      // level.
      EXPECT_EQ(grid[0].first_column, first);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        EXPECT_EQ(grid[i].width_px << i, grid[0].width_px);
        EXPECT_EQ((grid[i].first_column * 256 + grid[i].shift_x_px) << i, first * 256);
        EXPECT_GE((grid[i].first_column * 256 + grid[i].shift_x_px + grid[i].columns * 256) << i,
                  (first + count) * 256);
      }
    }
  }
}

TEST(TileTable, SaysThatThoseOfOtherProgramsHaveNone) {
  const test::TemporaryFolder folder;
  auto db = *SqliteDb::Open(folder / "map.mbtiles", OpenMode::kReadWriteCreate);
  ASSERT_TRUE(db.Exec("CREATE TABLE tiles(zoom_level, tile_column, tile_row, tile_data)"));
  EXPECT_EQ(ReadTileTable(db).error().code, ErrorCode::kUnsupportedFormat);
}

}  // namespace
}  // namespace skyquilt::storage
