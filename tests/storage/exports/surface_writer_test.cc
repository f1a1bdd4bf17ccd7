#include "storage/exports/heights/surface_writer.h"

#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <limits>

#include "core/flight/remarks/because.h"
#include "core/surface/terrain/ground_sketch.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr double kCellM = 0.5;
const geo::Wgs84 kOrigin{46.95, 7.44, 560.0};
const geo::LatLon kMiddle{46.95, 7.466};

// Two kilometres east of the frame's origin, where the Earth has bent away by a third of a metre.
surface::SurfaceGrid FarGrid() { return {Eigen::Vector2d(2000.0, -500.0), kCellM, 120, 90}; }

double TrueZ(double east, double north) { return 4.0 + 0.05 * (east - 2000.0) + 0.02 * (north + 500.0); }

// A block of a slope: the first five columns of the grid unseen, the last twenty filled.
surface::SurfaceBlock SlopeBlock(const surface::SurfaceGrid& grid, const surface::CellBox& box) {
  surface::SurfaceBlock block{box, {}};
  for (int row = box.row; row < box.row + box.rows; ++row) {
    for (int column = box.column; column < box.column + box.columns; ++column) {
      const Eigen::Vector2d place = grid.south_west_in_enu + grid.cell_m * Eigen::Vector2d(column, row);
      const bool is_seen = column >= 5, is_measured = is_seen && column < 100;
      block.cells.heights_m.push_back(is_seen ? static_cast<float>(TrueZ(place.x(), place.y()))
                                              : std::numeric_limits<float>::quiet_NaN());
      block.cells.confidence.push_back(is_measured ? 200 : 0);
      block.cells.agreeing_photos.push_back(is_measured ? 3 : 0);
    }
  }
  return block;
}

double ValueAt(GDALDataset& raster, double x, double y) {
  const auto transform = test::TransformOf(raster);
  return test::PixelAt<double>(*raster.GetRasterBand(1),
                               static_cast<int>(std::floor((x - transform[0]) / transform[1])),
                               static_cast<int>(std::floor((y - transform[3]) / transform[5])));
}

Eigen::Vector2d UtmOf(GDALDataset& raster, const geo::Wgs84& place) {
  OGRSpatialReference degrees;
  degrees.importFromEPSG(4326);
  degrees.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> utm_from_degrees(
      OGRCreateCoordinateTransformation(&degrees, raster.GetSpatialRef()));
  double x = place.lon_deg, y = place.lat_deg;
  EXPECT_TRUE(utm_from_degrees->Transform(1, &x, &y));
  return {x, y};
}

// The whole of the grid.
Result<void> WriteSlope(const test::TemporaryFolder& folder, const geo::LocalFrame& frame,
                        const geo::LatLon& map_middle = kMiddle, double raised_m = 0.0) {
  SilentProgress progress;
  SurfaceWriter writer(folder.path(), frame, map_middle, FarGrid(), 6.0, 1, nullptr, progress, raised_m);
  EXPECT_TRUE(writer.Begin());
  EXPECT_TRUE(writer.Put(SlopeBlock(FarGrid(), {0, 0, 120, 90})));
  return writer.Publish();
}

TEST(SurfaceWriter, HeightsLieWhereTheyAreInUtmAboveTheEllipsoid) {
  const test::TemporaryFolder folder;
  const geo::LocalFrame frame(kOrigin);
  const surface::SurfaceGrid grid = FarGrid();
  SilentProgress progress;
  SurfaceWriter writer(folder.path(), frame, kMiddle, grid, 6.0, 1, nullptr, progress);
  ASSERT_TRUE(writer.Begin());
  ASSERT_TRUE(writer.Put(SlopeBlock(grid, {64, 0, 56, 90})));
  ASSERT_TRUE(writer.Put(SlopeBlock(grid, {0, 0, 64, 90})));
  ASSERT_TRUE(writer.Publish());
  EXPECT_NEAR(writer.MeasuredShare(), 95.0 / 115.0, 1e-9);

  const auto heights = test::OpenByGdal(folder / "dsm.tif"),
             photos = test::OpenByGdal(folder / "dsm_photos.tif");
  EXPECT_STREQ(heights->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
  EXPECT_STREQ(heights->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  EXPECT_EQ(heights->GetRasterBand(1)->GetRasterDataType(), GDT_Float32);
  EXPECT_TRUE(std::isnan(heights->GetRasterBand(1)->GetNoDataValue()));
  EXPECT_STREQ(heights->GetRasterBand(1)->GetUnitType(), "m");
  EXPECT_EQ(photos->GetRasterBand(1)->GetRasterDataType(), GDT_Byte);

  for (int column = 0; column < grid.columns; column += 7) {
    for (int row = 3; row < grid.rows - 3; row += 11) {
      const Eigen::Vector2d place = grid.south_west_in_enu + grid.cell_m * Eigen::Vector2d(column, row);
      const geo::Wgs84 truth = frame.Wgs84FromEnu({place.x(), place.y(), TrueZ(place.x(), place.y())});
      const Eigen::Vector2d at = UtmOf(*heights, truth);
      const double x = at.x(), y = at.y(), height_m = ValueAt(*heights, x, y);
      if (column < 4) {
        EXPECT_TRUE(std::isnan(height_m));
        EXPECT_EQ(ValueAt(*photos, x, y), 0.0);
      } else if (column > 6) {
        // The middle of the cell asked may lie half a cell off: 1.3 cm on this slope.
        EXPECT_NEAR(height_m, truth.height_ellipsoid_m, 0.02) << column << " " << row;
        if (column < 98 || column > 102) {
          EXPECT_EQ(ValueAt(*photos, x, y), column < 100 ? 3.0 : 0.0);
        }
      }
    }
  }
}

TEST(SurfaceWriter, CountsHeightsFromWhereASurveyDoes) {
  const test::TemporaryFolder folder;
  const geo::LocalFrame frame(kOrigin);
  const surface::SurfaceGrid grid = FarGrid();
  ASSERT_TRUE(WriteSlope(folder, frame, kMiddle, -47.25));
  const auto heights = test::OpenByGdal(folder / "dsm.tif");
  const Eigen::Vector2d place = grid.south_west_in_enu + grid.cell_m * Eigen::Vector2d(50.0, 40.0);
  const geo::Wgs84 truth = frame.Wgs84FromEnu({place.x(), place.y(), TrueZ(place.x(), place.y())});
  const Eigen::Vector2d at = UtmOf(*heights, truth);
  EXPECT_NEAR(ValueAt(*heights, at.x(), at.y()), truth.height_ellipsoid_m - 47.25, 0.02);
}

TEST(SurfaceWriter, WritesTheGroundBelowAsWell) {
  const test::TemporaryFolder folder;
  const surface::SurfaceGrid grid = FarGrid();
  SilentProgress progress;
  surface::GroundSketch sketch(grid.columns, grid.rows, grid.cell_m);
  SurfaceWriter writer(folder.path(), geo::LocalFrame(kOrigin), kMiddle, grid, 6.0, 1, &sketch, progress);
  ASSERT_TRUE(writer.Begin());
  surface::SurfaceBlock block = SlopeBlock(grid, {0, 0, 120, 90});
  const auto is_house = [](int column, int row) {
    return column >= 40 && column < 60 && row >= 30 && row < 50;
  };
  for (int row = 0; row < 90; ++row) {
    for (int column = 0; column < 120; ++column) {
      if (is_house(column, row)) block.cells.heights_m[static_cast<std::size_t>(row) * 120 + column] += 6.0f;
    }
  }
  ASSERT_TRUE(writer.Put(block));
  ASSERT_TRUE(writer.Publish());
  const auto heights = test::OpenByGdal(folder / "dsm.tif"), ground = test::OpenByGdal(folder / "dtm.tif"),
             seen = test::OpenByGdal(folder / "dtm_ground.tif");
  EXPECT_STREQ(ground->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  const auto transform = test::TransformOf(*heights);
  int below = 0, same = 0, unseen = 0;
  for (int row = 0; row < heights->GetRasterYSize(); ++row) {
    for (int column = 0; column < heights->GetRasterXSize(); ++column) {
      const double x = transform[0] + (column + 0.5) * transform[1],
                   y = transform[3] + (row + 0.5) * transform[5];
      const double shown = ValueAt(*heights, x, y), under = ValueAt(*ground, x, y);
      ASSERT_EQ(std::isnan(shown), std::isnan(under));
      if (std::isnan(shown)) continue;
      ASSERT_LE(under, shown + 1e-3);
      below += under < shown - 4.0 ? 1 : 0;
      same += std::abs(under - shown) < 1e-3 ? 1 : 0;
      unseen += ValueAt(*seen, x, y) == 0.0 ? 1 : 0;
    }
  }
  EXPECT_NEAR(below, 20 * 20, 60);  // edges are resampled
  EXPECT_NEAR(same, 115 * 90 - 400, 120);
  EXPECT_NEAR(unseen, 20 * 90 + 400, 160);  // filled, and below the house
}

TEST(SurfaceWriter, LeavesNothingBesideWhenItIsGivenUp) {
  const test::TemporaryFolder folder;
  {
    SilentProgress progress;
    SurfaceWriter writer(folder.path(), geo::LocalFrame(kOrigin), kMiddle, FarGrid(), 6.0, 1, nullptr,
                         progress);
    ASSERT_TRUE(writer.Begin());
    ASSERT_TRUE(writer.Put(SlopeBlock(FarGrid(), {0, 0, 120, 90})));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// A disk that is full, or a process that dies, while the second file is made.
TEST(SurfaceWriter, LeavesTheHeightsOfAnEarlierMapUntilAllOfItsOwnAreThere) {
  const test::TemporaryFolder folder;
  for (const char* name : {"dsm.tif", "dsm_photos.tif"}) folder.Write(name, "of an earlier map");
  folder.Write("dsm_photos.tif.raw.tmp.warped.tmp/held", "");  // a folder where a file is to be
  EXPECT_FALSE(WriteSlope(folder, geo::LocalFrame(kOrigin)));
  for (const char* name : {"dsm.tif", "dsm_photos.tif"})
    EXPECT_EQ(test::BytesOf(folder / name), "of an earlier map") << name;
  EXPECT_FALSE(std::filesystem::exists(folder / "dsm.tif.raw.tmp"));
}

// A flight across the border of two zones, whose first photos lie in the other one than most of the map.
TEST(SurfaceWriter, CountsInTheZoneOfTheMapsMiddle) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(WriteSlope(folder, geo::LocalFrame(geo::Wgs84{-33.9, 17.99, 560.0}), {-33.9, 18.01}));
  for (const char* name : {"dsm.tif", "dsm_photos.tif"}) {
    EXPECT_STREQ(test::OpenByGdal(folder / name)->GetSpatialRef()->GetAuthorityCode(nullptr), "32734")
        << name;
  }
}

// A file of all that lies between them would take days, and a disk.
TEST(SurfaceWriter, FieldsFarApartHaveNoHeights) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  const surface::SurfaceGrid grid{Eigen::Vector2d::Zero(), 0.05, 800'000, 800'000};
  SurfaceWriter writer(folder.path(), geo::LocalFrame(kOrigin), kMiddle, grid, 6.0, 1, nullptr, progress);
  const Result<void> begun = writer.Begin();
  ASSERT_FALSE(begun.ok());
  EXPECT_EQ(begun.error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(flight::WhyOf(begun.error()).code, flight::RemarkCode::kFieldsFarApart);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(SurfaceWriter, SaysThatThereIsNoUtmAtThePoles) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  SurfaceWriter writer(folder.path(), geo::LocalFrame({86.0, 7.0, 0.0}), {86.0, 7.0}, FarGrid(), 6.0, 1,
                       nullptr, progress);
  EXPECT_EQ(test::ErrorOf(writer.Begin()).code, ErrorCode::kUnprocessable);
}

}  // namespace
}  // namespace skyquilt::storage
