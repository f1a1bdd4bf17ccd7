#include "storage/exports/warped/warp_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/warped/resample_block.h"
#include "storage/exports/warped/target_grid.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "tests/storage/painted_tileset.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr int kZoom = 19, kColumn = 272500, kRow = 184700, kTiles = 8;

double ShareShown(GDALDataset& map) {
  const std::vector<std::uint8_t> mask = test::PixelsOf(*map.GetRasterBand(1)->GetMaskBand());
  return static_cast<double>(std::count(mask.begin(), mask.end(), 255)) / static_cast<double>(mask.size());
}

class WarpTilesTest : public testing::Test {
 protected:
  void SetUp() override {
    RegisterGdalOnce();
    test::WritePaintedTileset(folder_.path() / "map.mbtiles", {kZoom, 256, kColumn, kRow, kTiles, kTiles});
    tiles_ = *MbtilesReader::Open(folder_.path() / "map.mbtiles");
    const geo::Bounds2 whole{geo::TileId::Make(kZoom, kColumn, kRow + kTiles - 1)->BoundsInMerc().min,
                             geo::TileId::Make(kZoom, kColumn + kTiles - 1, kRow)->BoundsInMerc().max};
    options_.bounds = geo::LatLonBoundsFromMerc(whole);
    options_.min_zoom = kZoom - 3;
    options_.max_zoom = kZoom;
    options_.target.epsg = 32632;
    options_.target.pixel_x = options_.target.pixel_y = 0.2;
  }
  Result<void> Warp(const char* name, int threads = 1) {
    options_.threads = threads;
    return WarpTiles(*tiles_, folder_.path() / name, options_, progress_);
  }
  std::unique_ptr<GDALDataset> Open(const char* name) { return test::OpenByGdal(folder_ / name); }

  test::TemporaryFolder folder_;
  std::shared_ptr<MbtilesReader> tiles_;
  WarpTilesOptions options_;
  SilentProgress progress_;
};

TEST_F(WarpTilesTest, MakesTheSameBytesWithAnyNumberOfThreads) {
  ASSERT_TRUE(Warp("one.tif", 1));
  ASSERT_TRUE(Warp("three.tif", 3));
  const std::string one = test::BytesOf(folder_.path() / "one.tif");
  EXPECT_GT(one.size(), 10'000u);
  EXPECT_TRUE(one == test::BytesOf(folder_.path() / "three.tif"));
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
}

TEST_F(WarpTilesTest, OverviewsShowTheSameAtTheSamePlace) {
  ASSERT_TRUE(Warp("map.tif"));
  const auto map = Open("map.tif");
  GDALRasterBand* green = map->GetRasterBand(2);
  ASSERT_EQ(green->GetOverviewCount(), 3);
  int compared = 0;
  // Within the disk that is shown.
  const int width = map->GetRasterXSize(), height = map->GetRasterYSize();
  for (int y = height / 4; y < 3 * height / 4; y += 37) {
    for (int x = width / 4; x < 3 * width / 4; x += 41) {
      EXPECT_NEAR(test::PixelAt(*green, x, y), test::PixelAt(*green->GetOverview(0), x / 2, y / 2), 12)
          << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 200);
}

TEST_F(WarpTilesTest, LargerPixelsAreMadeOfTheOverviews) {
  ASSERT_TRUE(Warp("fine.tif"));
  options_.target.pixel_x = options_.target.pixel_y = 1.6;
  options_.target.is_coarser = true;
  ASSERT_TRUE(Warp("coarse.tif"));
  const auto fine = Open("fine.tif"), coarse = Open("coarse.tif");
  EXPECT_NEAR(coarse->GetRasterXSize(), fine->GetRasterXSize() / 8.0, 2.0);
  // The middle of the map, as both see it.
  const auto from_fine = test::TransformOf(*fine), from_coarse = test::TransformOf(*coarse);
  const int x = coarse->GetRasterXSize() / 2, y = coarse->GetRasterYSize() / 2;
  const int u =
      static_cast<int>(std::round((from_coarse[0] + x * from_coarse[1] - from_fine[0]) / from_fine[1]));
  const int v =
      static_cast<int>(std::round((from_coarse[3] + y * from_coarse[5] - from_fine[3]) / from_fine[5]));
  double sum = 0.0;
  for (const std::uint8_t level : test::PixelsOf(*fine->GetRasterBand(1), u, v, 8, 8)) sum += level;
  EXPECT_NEAR(test::PixelAt(*coarse->GetRasterBand(1), x, y), sum / 64.0, 6.0);
}

TEST_F(WarpTilesTest, PixelsLargerThanThoseOfAnyOverview) {
  options_.target.pixel_x = options_.target.pixel_y = 30.0;
  options_.target.is_coarser = true;
  ASSERT_TRUE(Warp("coarse.tif"));
  const auto map = Open("coarse.tif");
  ASSERT_GT(map->GetRasterXSize(), 8);
  EXPECT_NEAR(ShareShown(*map), 0.7, 0.15);  // the disk
  const std::vector<std::uint8_t> levels = test::PixelsOf(*map->GetRasterBand(1));
  const std::size_t middle = levels.size() / 2 + map->GetRasterXSize() / 2;
  EXPECT_NEAR(levels[middle], 128, 40);  // of waves, about their mean
}

TEST_F(WarpTilesTest, AMapWithoutTilesWhereItSaysSoIsRefused) {
  options_.max_zoom = kZoom + 3;
  options_.target.pixel_x = options_.target.pixel_y = 0.01;
  EXPECT_EQ(test::ErrorOf(Warp("map.tif")).code, ErrorCode::kCorrupt);
}

TEST_F(WarpTilesTest, DegreesAreSaidToBeDegrees) {
  options_.target.epsg = 4326;
  options_.target.pixel_x = options_.target.pixel_y = 2e-6;
  ASSERT_TRUE(Warp("degrees.tif"));
  const auto map = Open("degrees.tif");
  EXPECT_TRUE(map->GetSpatialRef()->IsGeographic());
  EXPECT_STREQ(map->GetSpatialRef()->GetAuthorityCode(nullptr), "4326");
  const auto place = test::TransformOf(*map);
  EXPECT_NEAR(place[0], options_.bounds.west_deg, 4e-6);
  EXPECT_NEAR(place[3], options_.bounds.north_deg, 4e-6);
}

TEST_F(WarpTilesTest, OneThatIsCancelledLeavesNothing) {
  class Cancelled final : public Progress {
   public:
    void BeginStage(std::string_view) override {}
    void Report(double, std::string_view) override {}
    bool IsCancelled() const override { return true; }
  } cancelled;
  EXPECT_EQ(test::ErrorOf(WarpTiles(*tiles_, folder_.path() / "map.tif", options_, cancelled)).code,
            ErrorCode::kCancelled);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    EXPECT_EQ(entry.path().filename().string().find("map.tif"), std::string::npos) << entry.path();
}

TEST(WarpTiles, GoesOnBeyondTheDateLine) {
  RegisterGdalOnce();
  const test::TemporaryFolder folder;
  const int around = 1 << 12;
  test::WritePaintedTileset(folder.path() / "map.mbtiles", {12, 256, around - 2, 1500, 2, 2});
  const auto tiles = *MbtilesReader::Open(folder.path() / "map.mbtiles");
  WarpTilesOptions options;
  const geo::Bounds2 west{geo::TileId::Make(12, around - 2, 1501)->BoundsInMerc().min,
                          geo::TileId::Make(12, around - 1, 1500)->BoundsInMerc().max};
  options.bounds = geo::LatLonBoundsFromMerc(west);
  options.bounds.east_deg += 0.05;  // beyond, where nothing is shown
  options.min_zoom = 11;
  options.max_zoom = 12;
  options.target.epsg = 32660;
  options.target.pixel_x = options.target.pixel_y = 40.0;
  SilentProgress progress;
  const auto written = WarpTiles(*tiles, folder.path() / "map.tif", options, progress);
  ASSERT_TRUE(written) << written.error().message;
  // A disk of 0.48 of the smaller side.
  EXPECT_NEAR(ShareShown(*test::OpenByGdal(folder / "map.tif")), 0.62, 0.12);
}

TEST(TargetGrid, GoesOnBeyondTheDateLine) {
  const geo::LatLonBounds bounds{179.99, -17.0, 180.01, -16.99};
  for (const auto& [epsg, pixel, width] : {std::tuple{3857, 1.0, 2226},
                                           {3395, 1.0, 2226},
                                           {4326, 1e-5, 2000},
                                           {32660, 1.0, 2130},
                                           {3832, 1.0, 2226}}) {
    const auto grid = TargetGrid::Cover(bounds, epsg, pixel, pixel);
    ASSERT_TRUE(grid) << epsg << " " << grid.error().message;
    EXPECT_NEAR((*grid)->width_px(), width, 30) << epsg;
    const auto corners = (*grid)->CornersInMerc(0, 0, static_cast<int>((*grid)->width_px()), 2, 1);
    EXPECT_NEAR(corners[1].x() - corners[0].x(), 2226.0, 30.0) << epsg;
  }
}

TEST(TargetGrid, OfTooManyPixelsIsRefused) {
  EXPECT_FALSE(TargetGrid::Cover({-170.0, -80.0, 170.0, 80.0}, 3857, 0.001, 0.001));
  const Error refused = test::ErrorOf(TargetGrid::Cover({7.0, 46.0, 7.1, 46.1}, 900913, 1.0, 1.0));
  EXPECT_NE(refused.message.find("EPSG:900913"), std::string::npos) << refused.message;
}

TEST(ResamplingKernel, WeighsWhatLiesAround) {
  for (const double ratio : {0.3, 1.0, 1.29, 1.99}) {
    // The part of a pixel that the mean takes in lies beside the pixel's centre.
    for (const auto& [kernel, tolerance] : {std::pair{ResamplingKernel::Cubic(ratio), 0.02},
                                            std::pair{ResamplingKernel::Average(ratio), 0.15}}) {
      for (const float fraction : {0.0F, 0.25F, 0.5F, 0.999F, 1.0F}) {
        const float* weights = kernel.WeightsAt(fraction);
        double sum = 0.0, centre = 0.0;
        for (int i = 0; i < kernel.size(); ++i) {
          sum += weights[i];
          centre += weights[i] * (kernel.first() + i);
        }
        EXPECT_NEAR(sum, 1.0, 1e-5);
        EXPECT_NEAR(centre, fraction, tolerance) << ratio << " " << fraction;
      }
    }
  }
  EXPECT_EQ(ResamplingKernel::Cubic(1.0).size(), 4);
}

}  // namespace
}  // namespace skyquilt::storage
