#include "storage/exports/heights/contours.h"

#include <ogrsf_frmts.h>

#include <cmath>

#include "storage/files/publish_file.h"
#include "tests/storage/exports/heights_raster.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

constexpr int kSide = 200;
constexpr double kWestM = kHeightsWestM, kNorthM = kHeightsNorthM;

// A cone of 5 m radius and as high, 560 m above the ellipsoid; nothing is known beyond.
double ConeAt(double east_m, double north_m) {
  const double away = std::hypot(east_m - kWestM - 10.0, north_m - kNorthM + 10.0);
  return away > 9.0 ? std::numeric_limits<double>::quiet_NaN() : 560.0 + std::max(0.0, 5.0 - away);
}

std::unique_ptr<GDALDataset> OpenLines(const std::filesystem::path& path) {
  return test::OpenByGdal(path, GDAL_OF_VECTOR);
}

TEST(Contours, AreRoundTheirConeAtTheirHeightInEachFormat) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteHeights(folder.path() / "dtm.tif", kSide, ConeAt);
  EXPECT_EQ(test::ValueOf(WriteContours(folder.path() / "dtm.tif", 0.2, progress)), 0.2);
  const auto gpkg = OpenLines(folder.path() / "contours.gpkg");
  OGRLayer* layer = gpkg->GetLayerByName("contours");
  ASSERT_NE(layer, nullptr);
  EXPECT_STREQ(layer->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
  int lines = 0;
  for (auto& feature : *layer) {
    const double height_m = feature->GetFieldAsDouble("height_m");
    EXPECT_NEAR(height_m / 0.2, std::round(height_m / 0.2), 1e-6);
    if (height_m < 560.1) continue;  // the plain has no heights to follow
    const OGRLineString& line = *feature->GetGeometryRef()->toLineString();
    EXPECT_NEAR(line.getZ(0), height_m, 1e-6);
    for (int i = 0; i < line.getNumPoints(); ++i)
      EXPECT_NEAR(std::hypot(line.getX(i) - kWestM - 10.0, line.getY(i) - kNorthM + 10.0), 565.0 - height_m,
                  0.1);
    ++lines;
  }
  EXPECT_GE(lines, 22);
  EXPECT_LE(lines, 25);

  const auto geojson = OpenLines(folder.path() / "contours.geojson"),
             dxf = OpenLines(folder.path() / "contours.dxf");
  EXPECT_EQ(geojson->GetLayer(0)->GetFeatureCount(), layer->GetFeatureCount());
  EXPECT_EQ(dxf->GetLayer(0)->GetFeatureCount(), layer->GetFeatureCount());
  OGREnvelope3D of_geojson, of_dxf;
  ASSERT_EQ(geojson->GetLayer(0)->GetExtent(&of_geojson, TRUE), OGRERR_NONE);
  EXPECT_GT(of_geojson.MinX, 7.0);
  EXPECT_LT(of_geojson.MaxY, 48.0);
  double highest = 0.0;
  for (auto& feature : *dxf->GetLayer(0)) {
    feature->GetGeometryRef()->getEnvelope(&of_dxf);
    highest = std::max(highest, of_dxf.MaxZ);
  }
  EXPECT_GT(highest, 564.0);
}

TEST(Contours, OfLevelAndOfUnknownGroundAreFilesWithoutLines) {
  SilentProgress progress;
  for (double (*height_at)(double, double) :
       {+[](double, double) { return 3.04; }, +[](double, double) { return std::nan(""); }}) {
    const test::TemporaryFolder folder;
    WriteHeights(folder.path() / "dtm.tif", kSide, height_at);
    EXPECT_EQ(test::ValueOf(WriteContours(folder.path() / "dtm.tif", 0.5, progress)), 0.1);
    for (const char* name : {"contours.gpkg", "contours.geojson", "contours.dxf"}) {
      const auto lines = OpenLines(folder.path() / name);
      EXPECT_TRUE(lines->GetLayerCount() == 0 || lines->GetLayer(0)->GetFeatureCount() == 0) << name;
    }
  }
}

TEST(Contours, AreTheSameBytesEachTime) {
  const test::TemporaryFolder first, second;
  SilentProgress progress;
  for (const test::TemporaryFolder* folder : {&first, &second}) {
    WriteHeights(folder->path() / "dtm.tif", kSide, ConeAt);
    ASSERT_TRUE(WriteContours(folder->path() / "dtm.tif", 0.2, progress));
  }
  for (const char* name : {"contours.gpkg", "contours.geojson", "contours.dxf"})
    EXPECT_EQ(*ReadWholeFile(first.path() / name), *ReadWholeFile(second.path() / name)) << name;
}

TEST(Contours, ArePublishedTogetherOrNotAtAll) {
  const test::TemporaryFolder folder;
  SilentProgress progress;
  WriteHeights(folder.path() / "dtm.tif", kSide, ConeAt);
  folder.Write("contours.gpkg", "of an earlier map");
  // The last of them cannot be written.
  std::filesystem::create_directories(folder.path() / "contours.tmp.dxf" / "in_the_way");
  EXPECT_FALSE(WriteContours(folder.path() / "dtm.tif", 0.2, progress));
  for (const char* name : {"contours.gpkg", "contours.geojson", "contours.dxf"})
    EXPECT_FALSE(std::filesystem::exists(folder.path() / name)) << name;
}

TEST(ContourInterval, IsTheLeastThatDrawsFew) {
  EXPECT_EQ(ContourIntervalM(0.0, 0.0), 0.1);
  EXPECT_EQ(ContourIntervalM(560.0, 563.9), 0.1);
  EXPECT_EQ(ContourIntervalM(560.0, 565.0), 0.2);
  EXPECT_EQ(ContourIntervalM(-10.0, 150.0), 5.0);
  EXPECT_EQ(ContourIntervalM(0.0, 1500.0), 50.0);
}

}  // namespace
}  // namespace skyquilt::storage
