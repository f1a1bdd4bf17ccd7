// The bands of a map at any grid, against what was written; and classes as outlines, read back by GDAL.
#include "storage/rasters/band_raster.h"

#include <cpl_vsi.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "core/geo/web_mercator.h"
#include "storage/rasters/class_outlines.h"
#include "storage/rasters/open_rasters.h"
#include "tests/storage/rasters/band_file.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<std::size_t, 2> kNirAndGreen = {1, 0};

// 300 by 200 pixels of half a metre from (1000, 5000) on; left of column 20 nothing is known.
test::BandFile Sample() {
  return {1000.0, 5000.0, 0.5, 300, 200, {"green", "NIR"}, [](int band, int column, int row) {
            return column < 20 ? kNan : static_cast<float>(band) + static_cast<float>(column + row) / 1000.0f;
          }};
}

class BandRasterTest : public testing::Test {
 protected:
  std::shared_ptr<BandRaster> Opened(const test::BandFile& file) {
    test::WriteBandFile(path_, file);
    Result<std::shared_ptr<BandRaster>> raster = BandRaster::Open(path_);
    EXPECT_TRUE(raster);
    return raster ? *raster : nullptr;
  }
  test::TemporaryFolder scratch_;
  std::filesystem::path path_ = scratch_.path() / "bands.tif";
};

TEST_F(BandRasterTest, AtItsOwnPixelsValuesAreThoseOfTheFile) {
  const auto raster = Opened(Sample());
  EXPECT_EQ(raster->bands(), (std::vector<std::string>{"green", "nir"}));
  // Reaches 10 pixels beyond the west and 20 beyond the north.
  const auto planes = *raster->Read({995.0, 5010.0, 0.5, 0.5, 64, 32}, kNirAndGreen);
  ASSERT_EQ(planes.size(), 2u);
  for (int row = 0; row < 32; ++row) {
    for (int column = 0; column < 64; ++column) {
      const float nir = planes[0][static_cast<std::size_t>(row * 64 + column)];
      const int c = column - 10, r = row - 20;
      if (c < 20 || r < 0) {
        EXPECT_TRUE(std::isnan(nir)) << column << " " << row;
      } else {
        EXPECT_EQ(nir, 1.0f + static_cast<float>(c + r) / 1000.0f) << column << " " << row;
        EXPECT_EQ(planes[1][static_cast<std::size_t>(row * 64 + column)],
                  static_cast<float>(c + r) / 1000.0f);
      }
    }
  }
}

TEST_F(BandRasterTest, WholeNumbersGoThroughScaleAndOffset) {
  test::BandFile file = Sample();
  file.is_whole_numbers = true;
  const auto planes = *Opened(file)->Read({1000.0, 5000.0, 0.5, 0.5, 300, 200}, kNirAndGreen);
  EXPECT_TRUE(std::isnan(planes[1][5]));
  EXPECT_NEAR(planes[1][100], 0.1f, 1e-6);
  EXPECT_NEAR(planes[0][199 * 300 + 299], 1.498f, 1e-6);
}

TEST_F(BandRasterTest, CoarserPixelsAreMeansOfWhatIsKnown) {
  for (const bool has_overviews : {true, false}) {
    test::BandFile file = Sample();
    file.has_overviews = has_overviews;
    file.width_px = 304;  // of which overviews take every eighth
    const auto planes = *Opened(file)->Read({1000.0, 5000.0, 4.0, 4.0, 37, 25}, kNirAndGreen);
    // Eight pixels: columns 16 to 23, of which 20 to 23 are known, and 24 to 31.
    EXPECT_TRUE(std::isnan(planes[1][1])) << has_overviews;
    EXPECT_NEAR(planes[1][2], (21.5 + 3.5) / 1000, 1e-4) << has_overviews;
    EXPECT_NEAR(planes[1][3], (27.5 + 3.5) / 1000, 1e-6) << has_overviews;
  }
}

TEST_F(BandRasterTest, BesideItNothingIsKnown) {
  const auto raster = Opened(Sample());
  for (const MercGrid& grid : {MercGrid{0.0, 0.0, 1.0, 1.0, 8, 8}, MercGrid{1e7, 5000.0, 0.5, 0.5, 8, 8},
                               MercGrid{-2e7, 2e7, 1e5, 1e5, 8, 8}}) {
    const auto planes = test::ValueOf(raster->Read(grid, kNirAndGreen));
    for (const float value : planes[0]) EXPECT_TRUE(std::isnan(value));
  }
  EXPECT_EQ(raster->Read({0, 0, 1, 1, 100'000, 8}, kNirAndGreen).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(raster->Read({0, 0, 1, 1, 0, 8}, kNirAndGreen).error().code, ErrorCode::kInvalidArgument);
  // Finer than it is: each pixel twice.
  const auto fine = *raster->Read({1020.0, 5000.0, 0.25, 0.25, 8, 8}, kNirAndGreen);
  EXPECT_EQ(fine[1][0], fine[1][1]);
  EXPECT_EQ(fine[1][2], 0.041f);
}

TEST_F(BandRasterTest, AcrossTheAntimeridianTilesAtBothEndsOfTheWebMapShowIt) {
  for (const double turn : {0.0, -1.0}) {
    test::BandFile file = Sample();
    // The antimeridian lies at column 150.
    file.west_m = (1.0 + 2.0 * turn) * geo::kMercHalfWidthM - 75.0;
    const auto raster = Opened(file);
    EXPECT_NEAR(raster->BoundsInMerc().min.x(), geo::kMercHalfWidthM - 75.0, 1e-6) << turn;
    const auto east = *raster->Read({-geo::kMercHalfWidthM, 5000.0, 0.5, 0.5, 8, 8}, kNirAndGreen);
    EXPECT_EQ(east[1].front(), 0.150f) << turn;
    const auto west = *raster->Read({geo::kMercHalfWidthM - 4.0, 5000.0, 0.5, 0.5, 8, 8}, kNirAndGreen);
    EXPECT_EQ(west[1].front(), 0.142f) << turn;
  }
}

TEST_F(BandRasterTest, RefusesWhatIsNoSuchFile) {
  EXPECT_EQ(BandRaster::Open(path_).error().code, ErrorCode::kCorrupt);
  std::ofstream(path_) << "not a GeoTIFF";
  EXPECT_EQ(BandRaster::Open(path_).error().code, ErrorCode::kCorrupt);
  test::WriteBandFile(path_, Sample());
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  const auto cut = BandRaster::Open(path_);
  const auto planes = cut ? (*cut)->Read({1000.0, 5000.0, 0.5, 0.5, 300, 200}, kNirAndGreen)
                          : Result<std::vector<std::vector<float>>>(cut.error());
  ASSERT_FALSE(planes);
  EXPECT_EQ(planes.error().code, ErrorCode::kCorrupt);
}

TEST_F(BandRasterTest, ManyThreadsReadTheSame) {
  const auto raster = Opened(Sample());
  const auto expected = *raster->Read({1000.0, 5000.0, 1.0, 1.0, 150, 100}, kNirAndGreen);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      for (int times = 0; times < 10; ++times) {
        const auto planes = raster->Read({1000.0, 5000.0, 1.0, 1.0, 150, 100}, kNirAndGreen);
        if (!planes || std::memcmp((*planes)[0].data(), expected[0].data(), expected[0].size() * 4) != 0)
          ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(BandRasterTest, AreOpenedOnceForARevision) {
  test::WriteBandFile(path_, Sample());
  OpenRasters<BandRaster> rasters;
  int asked = 0;
  const auto open = [&]() {
    ++asked;
    return BandRaster::Open(path_);
  };
  const auto first = *rasters.Get("flight", 1, open);
  EXPECT_EQ(*rasters.Get("flight", 1, open), first);
  EXPECT_EQ(asked, 1);
  EXPECT_NE(*rasters.Get("flight", 2, open), first);
  const auto none = [&]() -> Result<std::shared_ptr<BandRaster>> {
    ++asked;
    return std::shared_ptr<BandRaster>();
  };
  EXPECT_EQ(*rasters.Get("other", 1, none), nullptr);
  EXPECT_EQ(*rasters.Get("other", 1, open), nullptr);  // a revision never changes
  EXPECT_EQ(asked, 3);
  const auto away = []() -> Result<std::shared_ptr<BandRaster>> {
    return Error{ErrorCode::kUnavailable, "away", ""};
  };
  EXPECT_EQ(rasters.Get("third", 1, away).error().code, ErrorCode::kUnavailable);
  EXPECT_NE(*rasters.Get("third", 1, open), nullptr);  // tried again
}

// Two halves, a hole of one cell in the western one, and a column without class.
ClassGrid Halves() {
  ClassGrid grid{{1000.0, 5000.0, 10.0, 10.0, 20, 10}, std::vector<std::uint8_t>(200, 1)};
  for (int row = 0; row < 10; ++row) {
    for (int column = 10; column < 20; ++column)
      grid.classes[static_cast<std::size_t>(row * 20 + column)] = column == 19 ? 0 : 2;
  }
  grid.classes[4 * 20 + 4] = 2;
  return grid;
}

TEST(ClassOutlinesTest, SievingJoinsSmallPatches) {
  ClassGrid grid = Halves();
  ASSERT_TRUE(SieveClasses(grid, 4));
  EXPECT_EQ(grid.classes[4 * 20 + 4], 1);
  EXPECT_EQ(grid.classes[4 * 20 + 15], 2);
}

std::unique_ptr<GDALDataset> OpenInMemory(const std::string& path, std::string& bytes) {
  VSIFCloseL(VSIFileFromMemBuffer(path.c_str(), reinterpret_cast<GByte*>(bytes.data()), bytes.size(), FALSE));
  return test::OpenByGdal(path, GDAL_OF_VECTOR);
}

TEST(ClassOutlinesTest, AreReadBackAsGeoJsonAndAsShapefile) {
  const std::vector<ClassFacts> facts = {{0.1, 0.3, 0.2, 9900.0}, {0.4, 0.6, 0.5, 9100.0}};
  for (const OutlineFormat format : {OutlineFormat::kGeoJson, OutlineFormat::kShapefile}) {
    const bool is_shapefile = format == OutlineFormat::kShapefile;
    auto bytes = test::ValueOf(OutlineClasses(Halves(), facts, format));
    const std::string path = is_shapefile ? "/vsimem/read.shz" : "/vsimem/read.geojson";
    const auto read = OpenInMemory(path, bytes);
    OGRLayer* const layer = read->GetLayer(0);
    ASSERT_EQ(layer->GetFeatureCount(), 2);
    double areas[2] = {0.0, 0.0};
    for (const auto& feature : *layer) {
      const int zone = feature->GetFieldAsInteger("zone");
      ASSERT_TRUE(zone == 1 || zone == 2);
      EXPECT_NEAR(feature->GetFieldAsDouble("mean"), zone == 1 ? 0.2 : 0.5, 1e-9);
      const OGRGeometry* const shape = feature->GetGeometryRef();
      OGREnvelope box;
      shape->getEnvelope(&box);
      EXPECT_NEAR(box.MaxY, 0.044916, 1e-5);  // 5000 m north of the equator in merc
      areas[zone - 1] = OGR_G_Area(OGRGeometry::ToHandle(const_cast<OGRGeometry*>(shape)));
    }
    // Cells: 99 and 91, with the one in the hole.
    EXPECT_NEAR(areas[0] / areas[1], 99.0 / 91.0, 1e-4);
    VSIUnlink(path.c_str());
  }
}

// 25 m on either side of the antimeridian, which goes through the third column.
TEST(ClassOutlinesTest, EndAtTheAntimeridianAndGoOnAtItsOtherSide) {
  const ClassGrid grid{{geo::kMercHalfWidthM - 25.0, 5000.0, 10.0, 10.0, 5, 2},
                       std::vector<std::uint8_t>(10, 1)};
  auto bytes = test::ValueOf(OutlineClasses(grid, std::vector<ClassFacts>(1), OutlineFormat::kGeoJson));
  const auto read = OpenInMemory("/vsimem/across.geojson", bytes);
  OGRLayer* const layer = read->GetLayer(0);
  ASSERT_EQ(layer->GetFeatureCount(), 1);
  constexpr double kDegPerM = 180.0 / geo::kMercHalfWidthM;
  for (const auto& feature : *layer) {
    const OGRMultiPolygon* const sides = feature->GetGeometryRef()->toMultiPolygon();
    ASSERT_EQ(sides->getNumGeometries(), 2);
    for (const OGRPolygon* side : *sides)
      EXPECT_NEAR(side->get_Area(), 25.0 * 20.0 * kDegPerM * kDegPerM, 1e-10);
  }
  VSIUnlink("/vsimem/across.geojson");
}

TEST(ClassOutlinesTest, RefusesMorePartsThanAnybodyCanUse) {
  ClassGrid chess{{0.0, 0.0, 1.0, 1.0, 400, 400}, std::vector<std::uint8_t>(160'000)};
  for (std::size_t i = 0; i < chess.classes.size(); ++i)
    chess.classes[i] = static_cast<std::uint8_t>(1 + (i / 400 + i) % 2);
  const Result<std::string> refused =
      OutlineClasses(chess, std::vector<ClassFacts>(2), OutlineFormat::kGeoJson);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnprocessable);
}

}  // namespace
}  // namespace skyquilt::storage
