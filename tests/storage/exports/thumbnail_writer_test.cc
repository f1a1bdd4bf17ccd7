#include "storage/exports/thumbnail_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "storage/exports/cog_writer.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

TEST(WriteThumbnail, ShowsTheMapSmallAndTransparentOutside) {
  const test::TemporaryFolder dir;
  test::WritePaintedTileset(dir.path() / "map.mbtiles",
                            {.first_column = 512, .first_row = 512, .columns = 8, .rows = 4});
  SilentProgress progress;
  ASSERT_TRUE(WriteCog(dir.path() / "map.mbtiles", dir.path() / "map.tif", {85, 1}, progress));
  ASSERT_TRUE(WriteThumbnail(dir.path() / "map.tif", dir.path() / "small.png", 300));
  const cv::Mat picture = cv::imread((dir.path() / "small.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.type(), CV_8UC4);
  EXPECT_EQ(std::max(picture.cols, picture.rows), 300);
  int covered = 0, open = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const auto alpha = picture.at<cv::Vec4b>(y, x)[3];
      covered += alpha == 255, open += alpha == 0;
    }
  }
  EXPECT_GT(covered, 5000);
  EXPECT_GT(open, 1000);
}

TEST(WriteTilesThumbnail, ShowsWhatTheGeotiffShows) {
  const test::TemporaryFolder dir;
  test::WritePaintedTileset(dir.path() / "map.mbtiles",
                            {.first_column = 512, .first_row = 512, .columns = 8, .rows = 4});
  SilentProgress progress;
  ASSERT_TRUE(WriteCog(dir.path() / "map.mbtiles", dir.path() / "map.tif", {85, 1}, progress));
  ASSERT_TRUE(WriteThumbnail(dir.path() / "map.tif", dir.path() / "raster.png", 300));
  ASSERT_TRUE(WriteTilesThumbnail(dir.path() / "map.mbtiles", dir.path() / "tiles.png", 300));
  const cv::Mat raster = cv::imread((dir.path() / "raster.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat tiles = cv::imread((dir.path() / "tiles.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(tiles.type(), CV_8UC4);
  ASSERT_EQ(tiles.size(), raster.size());
  int compared = 0;
  double sum = 0.0;
  for (int y = 0; y < tiles.rows; ++y) {
    for (int x = 0; x < tiles.cols; ++x) {
      const auto ours = tiles.at<cv::Vec4b>(y, x), theirs = raster.at<cv::Vec4b>(y, x);
      if (ours[3] < 255 || theirs[3] < 255) continue;
      ++compared;
      for (int c = 0; c < 3; ++c) sum += std::abs(int{ours[c]} - int{theirs[c]});
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_LT(sum / (3.0 * compared), 6.0);
}

// As GDAL writes them: the whole at that zoom would take 100 GB.
TEST(WriteTilesThumbnail, TakesLittleMemoryOfAMapOfOneZoom) {
  const test::TemporaryFolder dir;
  auto writer = *MbtilesWriter::Create(dir.path() / "map.mbtiles");
  image::RgbaImage white = image::RgbaImage::Transparent(256, 256);
  std::fill(white.rgba.begin(), white.rgba.end(), std::uint8_t{255});
  const auto tile = pyramid::EncodeTile(white, {});
  for (const int column : {0, 1, 2, 1'000, 20'001, 20'002, 20'003})
    ASSERT_TRUE(writer->Put(*geo::TileId::Make(20, column, 20 * (column % 2)), tile->format, tile->bytes));
  ASSERT_TRUE(writer->Publish({}));
  ASSERT_TRUE(WriteTilesThumbnail(dir.path() / "map.mbtiles", dir.path() / "tiles.png", 20'004));
  const cv::Mat picture = cv::imread((dir.path() / "tiles.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.type(), CV_8UC4);
  EXPECT_EQ(picture.cols, 20'004);
  for (const int channel : {0, 3}) EXPECT_EQ(picture.at<cv::Vec4b>(0, 20'002)[channel], 255);
  EXPECT_EQ(picture.at<cv::Vec4b>(0, 10'000)[3], 0);
}

TEST(WriteThumbnail, SaysWhatIsMissing) {
  const test::TemporaryFolder dir;
  EXPECT_FALSE(WriteTilesThumbnail(dir.path() / "none.mbtiles", dir.path() / "small.png", 300));
  EXPECT_FALSE(WriteThumbnail(dir.path() / "none.tif", dir.path() / "small.png", 300));
}

}  // namespace
}  // namespace skyquilt::storage
