// Heights of a map at places, on grids of the web map and within areas, against a slope with a box on it.
#include "storage/rasters/height_raster.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>
#include <utility>

#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

constexpr int kColumns = 700, kRows = 500;
constexpr double kWestM = 500'000.0, kNorthM = 5'200'000.0, kCellM = 0.25;  // of zone 32, on its meridian
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// By place in metres from the north-west corner; nothing is known in the eastern fifth.
double SlopeAt(double x_m, double y_m) { return 400.0 + 0.05 * x_m - 0.02 * y_m; }

struct Corner {
  int epsg = 32632;
  double west_m = kWestM, north_m = kNorthM;
};

void WriteRaster(const std::filesystem::path& path, GDALDataType type, int columns,
                 const std::function<float(int, int)>& value, const Corner& corner = {}) {
  RegisterGdalOnce();
  const std::array<const char*, 5> options = {"TILED=YES", "BLOCKXSIZE=256", "BLOCKYSIZE=256",
                                              "COMPRESS=DEFLATE", nullptr};
  GDALDataset* file = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), columns, kRows, 1, type, const_cast<char**>(options.data()));
  OGRSpatialReference zone;
  zone.importFromEPSG(corner.epsg);
  file->SetSpatialRef(&zone);
  std::array<double, 6> transform = {corner.west_m, kCellM, 0, corner.north_m, 0, -kCellM};
  file->SetGeoTransform(transform.data());
  if (type == GDT_Float32) file->GetRasterBand(1)->SetNoDataValue(std::nan(""));
  std::vector<float> row(static_cast<std::size_t>(columns));
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < columns; ++x) row[static_cast<std::size_t>(x)] = value(x, y);
    EXPECT_EQ(file->GetRasterBand(1)->RasterIO(GF_Write, 0, y, columns, 1, row.data(), columns, 1,
                                               GDT_Float32, 0, 0, nullptr),
              CE_None);
  }
  std::array<int, 2> levels = {2, 4};
  EXPECT_EQ(file->BuildOverviews("AVERAGE", 2, levels.data(), 0, nullptr, nullptr, nullptr), CE_None);
  GDALClose(file);
}

class HeightRasterTest : public testing::Test {
 protected:
  HeightRasterTest() {
    WriteRaster(heights_, GDT_Float32, kColumns, [](int x, int y) {
      return x >= 560 ? kNone : static_cast<float>(SlopeAt((x + 0.5) * kCellM, (y + 0.5) * kCellM));
    });
    WriteRaster(measured_, GDT_Byte, kColumns, [](int x, int) { return x < 280 ? 3.0f : 0.0f; });
  }
  std::shared_ptr<HeightRaster> Opened() const { return *HeightRaster::Open(heights_, measured_); }
  // A place by metres from the north-west corner.
  geo::LatLon At(double x_m, double y_m) const { return *zone_.LatLonOf({kWestM + x_m, kNorthM - y_m}); }
  geo::Boundary Square(double west_m, double north_m, double side_m) const {
    return {{{{At(west_m, north_m), At(west_m + side_m, north_m), At(west_m + side_m, north_m + side_m),
               At(west_m, north_m + side_m)}}}};
  }

  test::TemporaryFolder scratch_;
  std::filesystem::path heights_ = scratch_.path() / "dsm.tif",
                        measured_ = scratch_.path() / "dsm_photos.tif";
  geo::MapProjection zone_ = *geo::MapProjection::OfEpsg(32632);
};

TEST_F(HeightRasterTest, SaysTheHeightBetweenCellsAndNoneBesideThem) {
  const std::vector<geo::LatLon> places = {At(10.03, 20.41), At(0.13, 0.13), At(100.0, 124.8),
                                           At(150.0, 50.0),  At(-5.0, 50.0), At(10.0, 1000.0),
                                           {-80.0, 170.0}};
  const std::vector<std::optional<double>> found = *Opened()->HeightsAt(places);
  EXPECT_NEAR(*found[0], SlopeAt(10.03, 20.41), 1e-3);
  EXPECT_NEAR(*found[1], SlopeAt(0.13, 0.13), 1e-2);
  EXPECT_NEAR(*found[2], SlopeAt(100.0, 124.8), 1e-2);
  for (const std::size_t i : {3u, 4u, 5u, 6u}) EXPECT_FALSE(found[i]) << i;
}

TEST_F(HeightRasterTest, OnTheWebMapAtEveryZoomTheHeightIsThatOfThePlace) {
  const auto raster = Opened();
  for (const int zoom : {22, 20, 18, 16}) {
    const geo::TileId tile = geo::TileId::AtMerc(zoom, geo::MercFromLatLon(At(60.0, 60.0)));
    const geo::Bounds2 bounds = tile.BoundsInMerc();
    const double pixel_m = bounds.Width() / 256;
    const MercGrid grid{bounds.min.x(), bounds.max.y(), pixel_m, pixel_m, 256, 256};
    const std::vector<float> heights_m = *raster->GoingOnOver(grid);
    int known = 0;
    for (int i = 0; i < 256 * 256; i += 37) {
      const auto at = static_cast<std::size_t>(i);
      const Eigen::Vector2d in_zone = *zone_.PlaceOf(geo::LatLonFromMerc(
          {bounds.min.x() + (i % 256 + 0.5) * pixel_m, bounds.max.y() - (i / 256 + 0.5) * pixel_m}));
      const double x_m = in_zone.x() - kWestM, y_m = kNorthM - in_zone.y();
      EXPECT_TRUE(std::isfinite(heights_m[at]));
      if (x_m > 139.0 || x_m < 1.0 || y_m < 1.0 || y_m > 124.0) continue;
      ++known;
      // At the coarser levels of a slope of 5 per cent.
      EXPECT_NEAR(heights_m[at], SlopeAt(x_m, y_m), zoom >= 20 ? 2e-3 : 0.05) << zoom << " " << i;
    }
    EXPECT_GT(known, 50) << zoom;
  }
}

TEST_F(HeightRasterTest, BeyondTheMapItsHeightGoesOnWithoutACliff) {
  const geo::Bounds2 bounds = geo::TileId::AtMerc(16, geo::MercFromLatLon(At(1500.0, 60.0))).BoundsInMerc();
  const std::vector<float> beside = *Opened()->GoingOnOver(
      {bounds.min.x(), bounds.max.y(), bounds.Width() / 256, bounds.Width() / 256, 256, 256});
  for (const float height_m : beside) EXPECT_NEAR(height_m, SlopeAt(140.0, 60.0), 2.0);
  const std::vector<float> antipode = *Opened()->GoingOnOver({-2e7, -1e7, 1.0, 1.0, 8, 8});
  for (const float height_m : antipode) EXPECT_NEAR(height_m, 403.0, 5.0);
}

TEST_F(HeightRasterTest, OverTheWebMapNothingGoesOnBeyondWhatIsKnown) {
  const Eigen::Vector2d known = geo::MercFromLatLon(At(30.0, 60.0)),
                        unknown = geo::MercFromLatLon(At(150.0, 60.0));
  const SampledHeights here = *Opened()->Over({known.x(), known.y(), 0.3, 0.3, 40, 20});
  EXPECT_NEAR(here.heights_m.front(), SlopeAt(30.1, 60.1), 0.01);
  EXPECT_EQ(std::count(here.is_measured.begin(), here.is_measured.end(), 0), 0);
  const SampledHeights there = *Opened()->Over({unknown.x(), unknown.y(), 0.3, 0.3, 40, 20});
  EXPECT_TRUE(
      std::none_of(there.heights_m.begin(), there.heights_m.end(), [](float m) { return std::isfinite(m); }));
  EXPECT_FALSE(Opened()->Over({0.0, 0.0, 1.0, 1.0, 5000, 10}));
}

TEST_F(HeightRasterTest, OnAnotherMapsCellsItsHeightsLieWhereTheyAreMovedTo) {
  const HeightCells cells = **Opened()->Within(Square(40.0, 50.0, 20.0));
  const Eigen::Vector2d at = geo::MercFromLatLon(At(50.0, 60.0));
  const Eigen::Vector2d moved = geo::MercFromLatLon(At(52.0, 60.0)) - at;  // two metres east
  const SampledHeights still = *Opened()->On(cells, Eigen::Vector2d::Zero()),
                       there = *Opened()->On(cells, moved);
  ASSERT_EQ(there.heights_m.size(), cells.heights_m.size());
  for (std::size_t i = 0; i < cells.heights_m.size(); i += 71) {
    EXPECT_NEAR(still.heights_m[i], cells.heights_m[i], 2e-3);
    EXPECT_NEAR(there.heights_m[i], cells.heights_m[i] - 0.05 * 2.0, 2e-3);
    EXPECT_EQ(still.is_measured[i] != 0, cells.is_measured[i] != 0);
  }
}

TEST_F(HeightRasterTest, WithinAnAreaAreTheCellsWhoseMiddlesLieInIt) {
  const HeightCells cells = **Opened()->Within(Square(50.0, 50.0, 40.0));
  EXPECT_NEAR(cells.cell_m, kCellM / 0.9996, 1e-6);  // the zone's scale on its meridian
  EXPECT_EQ(std::count(cells.is_inside.begin(), cells.is_inside.end(), 1), 160 * 160);
  double sum = 0.0;
  int measured = 0;
  for (std::size_t i = 0; i < cells.heights_m.size(); ++i) {
    if (cells.is_inside[i] == 0) continue;
    sum += cells.heights_m[i];
    measured += cells.is_measured[i] != 0 ? 1 : 0;
  }
  EXPECT_NEAR(sum / (160 * 160), SlopeAt(70.0, 70.0), 1e-3);
  EXPECT_EQ(measured, 80 * 160);
  ASSERT_GT(cells.edge.size(), 600u);
  for (const surface::EdgeHeight& at : cells.edge) {
    EXPECT_NEAR(at.height_m,
                SlopeAt(50.0 + at.place_in_cells.x() * kCellM, 50.0 + at.place_in_cells.y() * kCellM), 0.02);
  }
  EXPECT_FALSE(*Opened()->Within(Square(2000.0, 0.0, 40.0)));
  const std::optional<HeightCells> of_nothing = *Opened()->Within(Square(50.0, 50.0, 0.0));
  EXPECT_TRUE(!of_nothing || std::count(of_nothing->is_inside.begin(), of_nothing->is_inside.end(), 1) == 0);
  // Half of it lies where nothing is known.
  EXPECT_NEAR(static_cast<double>((**Opened()->Within(Square(120.0, 50.0, 40.0))).edge.size()), 320.0, 20.0);
}

TEST_F(HeightRasterTest, AnAreaMayBeAllTheWorldAndItsEdgeEndless) {
  const geo::Boundary world{{{{{-85.0, -180.0}, {-85.0, 180.0}, {85.0, 180.0}, {85.0, -180.0}}}}};
  const HeightCells all = **Opened()->Within(world);
  EXPECT_EQ(std::count(all.is_inside.begin(), all.is_inside.end(), 1), kColumns * kRows);
  EXPECT_NEAR(all.cell_m, kCellM / 0.9996, 1e-6);
  EXPECT_TRUE(all.edge.empty());
  // Up and down over the raster, thousands of times.
  geo::Boundary zigzag{{{{}}}};
  for (int i = 0; i < 5000; ++i)
    zigzag.polygons[0][0].push_back(At(100.0 + 0.001 * i, i % 2 == 0 ? -2000.0 : 2000.0));
  EXPECT_LT((**Opened()->Within(zigzag)).edge.size(),
            2 * static_cast<std::size_t>(HeightRaster::kMaxEdgePlaces));
  // A side far longer than the raster is looked at cell by cell where it crosses it.
  const geo::Boundary wide{{{{At(-4000.0, 60.0), At(4000.0, 60.0), At(0.0, 4000.0)}}}};
  EXPECT_GT((**Opened()->Within(wide)).edge.size(), 500u);
}

// Across the 180th meridian GeoJSON counts from the other end of the Earth.
TEST_F(HeightRasterTest, AnAreaMayLieOnEitherSideOfTheAntimeridianAndOnBoth) {
  constexpr int kZone60South = 32760;
  const geo::MapProjection zone = *geo::MapProjection::OfEpsg(kZone60South);
  const Eigen::Vector2d on_it = *zone.PlaceOf({-17.0, 180.0});
  const Corner corner{kZone60South, std::floor(on_it.x()) - 90.0, std::floor(on_it.y()) + 60.0};
  WriteRaster(
      heights_, GDT_Float32, kColumns, [](int, int) { return 7.0f; }, corner);
  WriteRaster(
      measured_, GDT_Byte, kColumns, [](int, int) { return 3.0f; }, corner);
  const auto at = [&](double x_m, double y_m) {
    return *zone.LatLonOf({corner.west_m + x_m, corner.north_m - y_m});
  };
  EXPECT_GT(at(80.0, 60.0).lon_deg, 179.9);
  EXPECT_LT(at(100.0, 60.0).lon_deg, -179.9);
  for (const auto& [west_m, east_m] :
       {std::pair(95.0, 105.0), std::pair(70.0, 80.0), std::pair(60.0, 120.0)}) {
    const geo::Boundary area{{{{at(west_m, 30.0), at(east_m, 30.0), at(east_m, 70.0), at(west_m, 70.0)}}}};
    const std::optional<HeightCells> cells = *Opened()->Within(area);
    ASSERT_TRUE(cells) << west_m;
    EXPECT_EQ(std::count(cells->is_inside.begin(), cells->is_inside.end(), 1),
              std::lround((east_m - west_m) / kCellM) * 160)
        << west_m;
  }
}

TEST_F(HeightRasterTest, FilesThatAreNoHeightsAreDamaged) {
  EXPECT_EQ(Opened()->GoingOnOver({0, 0, 1, 1, 5000, 10}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(HeightRaster::Open(measured_, measured_).error().code, ErrorCode::kCorrupt);
  WriteRaster(measured_, GDT_Byte, kColumns - 1, [](int, int) { return 1.0f; });
  EXPECT_EQ(HeightRaster::Open(heights_, measured_).error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(HeightRaster::Open(scratch_.path() / "none.tif", measured_).error().code, ErrorCode::kCorrupt);
}

TEST_F(HeightRasterTest, ManyReadAtOnce) {
  const auto raster = Opened();
  const std::vector<geo::LatLon> places = {At(10.0, 20.0), At(100.0, 80.0)};
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([&] {
      for (int turn = 0; turn < 20; ++turn) {
        const auto found = raster->HeightsAt(places);
        if (!found || std::abs(*(*found)[1] - SlopeAt(100.0, 80.0)) > 1e-2) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace skyquilt::storage
