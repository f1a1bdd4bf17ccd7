// Elevation models written here through GDAL, as surveys and agencies give them away.
#include "storage/rasters/geotiff_dem.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/flight/lists/file_kinds.h"
#include "storage/files/publish_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

struct Model {
  int epsg = 4326;
  double west = 8.5, north = 47.42, cell = 0.0001;  // in the unit of the coordinate system
  int columns = 60, rows = 40;
  GDALDataType type = GDT_Float32;
  std::function<double(double x, double y)> height;  // by the coordinate system's east and north
  std::optional<double> hole;
  std::string unit;
  double scale = 1.0, offset = 0.0;
  int vertical_epsg = 0;  // of heights, where the system says it
};

class GeotiffDemTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { GDALAllRegister(); }

  std::filesystem::path Write(const Model& model, bool with_place = true) {
    const std::filesystem::path path = folder_.path() / "model.tif";
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const std::unique_ptr<GDALDataset> file(
        driver->Create(path.c_str(), model.columns, model.rows, 1, model.type, nullptr));
    if (with_place) {
      double corner[6] = {model.west, model.cell, 0.0, model.north, 0.0, -model.cell};
      file->SetGeoTransform(corner);
      OGRSpatialReference system;
      system.importFromEPSG(model.epsg);
      if (model.vertical_epsg != 0) {
        system.SetFromUserInput(
            ("EPSG:" + std::to_string(model.epsg) + "+" + std::to_string(model.vertical_epsg)).c_str());
      }
      file->SetSpatialRef(&system);
    }
    GDALRasterBand* band = file->GetRasterBand(1);
    if (model.hole) band->SetNoDataValue(*model.hole);
    if (!model.unit.empty()) band->SetUnitType(model.unit.c_str());
    if (model.scale != 1.0) band->SetScale(model.scale);
    if (model.offset != 0.0) band->SetOffset(model.offset);
    std::vector<double> row(static_cast<std::size_t>(model.columns));
    for (int r = 0; r < model.rows; ++r) {
      for (int c = 0; c < model.columns; ++c) {
        row[static_cast<std::size_t>(c)] =
            model.height(model.west + (c + 0.5) * model.cell, model.north - (r + 0.5) * model.cell);
      }
      EXPECT_EQ(
          band->RasterIO(GF_Write, 0, r, model.columns, 1, row.data(), model.columns, 1, GDT_Float64, 0, 0),
          CE_None);
    }
    return path;
  }

  std::unique_ptr<GeotiffDem> Open(const Model& model) {
    auto opened = GeotiffDem::Open(Write(model));
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    return opened.ok() ? *std::move(opened) : nullptr;
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(GeotiffDemTest, ReadsGeographicModelsBetweenTheirCells) {
  Model model;
  model.height = [](double lon, double lat) { return 400.0 + 1e4 * (lon - 8.5) - 2e4 * (lat - 47.42); };
  const auto dem = Open(model);
  for (const auto& [lat, lon] : {std::pair{47.41903, 8.50211}, std::pair{47.4177, 8.5049}}) {
    EXPECT_NEAR(dem->GroundHeightM({lat, lon}).value(), model.height(lon, lat), 0.02);
  }
}

TEST_F(GeotiffDemTest, ReadsModelsThatCountLongitudesFrom0To360Degrees) {
  Model model;
  model.west = 188.5;
  model.height = [](double lon, double) { return 400.0 + 1e4 * (lon - 188.5); };
  const auto dem = Open(model);
  EXPECT_NEAR(dem->GroundHeightM({47.418, -171.497}).value(), 430.0, 0.02);
  EXPECT_NEAR(dem->GroundHeightM({47.418, 188.503}).value(), 430.0, 0.02);
  EXPECT_FALSE(dem->GroundHeightM({47.418, -171.49}));
}

TEST_F(GeotiffDemTest, ReadsProjectedModels) {
  Model model;
  model.epsg = 32632;
  model.west = 465000.0;
  model.north = 5252000.0;
  model.cell = 2.0;
  model.height = [](double e, double n) { return 500.0 + 0.1 * (e - 465000.0) + 0.05 * (n - 5252000.0); };
  const auto dem = Open(model);
  OGRSpatialReference utm, wgs84;
  utm.importFromEPSG(32632);
  wgs84.importFromEPSG(4326);
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> back(OGRCreateCoordinateTransformation(&utm, &wgs84));
  double x = 465051.3;
  double y = 5251960.8;
  const double height_m = model.height(x, y);
  ASSERT_TRUE(back->Transform(1, &x, &y));
  EXPECT_NEAR(dem->GroundHeightM({y, x}).value(), height_m, 0.01);
}

TEST_F(GeotiffDemTest, KnowsHolesThatNoTagTells) {
  for (const auto& [type, mark] :
       {std::pair{GDT_Int16, -32768.0}, {GDT_Float32, -9999.0}, {GDT_Float32, 3.4e38}}) {
    Model model;
    model.type = type;
    model.height = [mark = mark](double lon, double) { return lon < 8.503 ? mark : 321.0; };
    const auto dem = Open(model);
    EXPECT_FALSE(dem->GroundHeightM({47.418, 8.502})) << mark;
    EXPECT_NEAR(dem->GroundHeightM({47.418, 8.50301}).value(), 321.0, 1e-3) << mark;
    EXPECT_NEAR(dem->GroundHeightM({47.418, 8.504}).value(), 321.0, 1e-3) << mark;
  }
}

TEST_F(GeotiffDemTest, KnowsNothingOutsideAndInHoles) {
  Model model;
  model.hole = -9999.0;
  model.height = [](double lon, double) {
    return lon < 8.502 ? -9999.0 : lon > 8.505 ? std::nan("") : 321.0;
  };
  const auto dem = Open(model);
  EXPECT_FALSE(dem->GroundHeightM({47.418, 8.5005}));
  EXPECT_FALSE(dem->GroundHeightM({47.418, 8.5058}));
  EXPECT_NEAR(dem->GroundHeightM({47.418, 8.5035}).value(), 321.0, 1e-6);
  // Beside a hole what is left of the four cells counts, not a share of -9999.
  EXPECT_NEAR(dem->GroundHeightM({47.418, 8.50199}).value(), 321.0, 1e-6);
  EXPECT_FALSE(dem->GroundHeightM({47.418, 8.52}));
  EXPECT_FALSE(dem->GroundHeightM({46.0, 8.5035}));
  EXPECT_FALSE(dem->GroundHeightM({-47.418, -171.0}));
}

TEST_F(GeotiffDemTest, KnowsHolesWhoseMarkNoFloatHolds) {
  Model model;
  model.hole = -9999.9;
  model.height = [](double lon, double) { return lon < 8.503 ? -9999.9 : 321.0; };
  const auto dem = Open(model);
  EXPECT_FALSE(dem->GroundHeightM({47.418, 8.501}));
  EXPECT_NEAR(dem->GroundHeightM({47.418, 8.5045}).value(), 321.0, 1e-6);
}

TEST_F(GeotiffDemTest, TurnsFeetAndScaledIntegersIntoMetres) {
  Model feet;
  feet.unit = "ft";
  feet.height = [](double, double) { return 1000.0; };
  EXPECT_NEAR(Open(feet)->GroundHeightM({47.418, 8.503}).value(), 304.8, 1e-4);
  Model survey_feet = feet;
  survey_feet.unit = "US survey foot";
  EXPECT_NEAR(Open(survey_feet)->GroundHeightM({47.418, 8.503}).value(), 1000.0 * 1200.0 / 3937.0, 1e-4);
  Model whole;
  whole.type = GDT_Int16;
  whole.scale = 0.1;
  whole.offset = 100.0;
  whole.height = [](double, double) { return 4321.0; };
  EXPECT_NEAR(Open(whole)->GroundHeightM({47.418, 8.503}).value(), 532.1, 1e-3);
}

TEST_F(GeotiffDemTest, TakesTheUnitOfTheVerticalAxisOrOfTheBandWhicheverIsNoMetre) {
  Model feet;
  feet.vertical_epsg = 6360;  // NAVD88, in US survey feet
  feet.unit = "m";            // as tools write it that know no other
  feet.height = [](double, double) { return 1000.0; };
  const auto by_axis = Open(feet);
  EXPECT_NEAR(by_axis->GroundHeightM({47.418, 8.503}).value(), 1000.0 * 1200.0 / 3937.0, 1e-4);
  EXPECT_EQ(by_axis->unknown_unit(), "");
  Model metres = feet;
  metres.vertical_epsg = 5773;
  metres.unit = "";
  EXPECT_NEAR(Open(metres)->GroundHeightM({47.418, 8.503}).value(), 1000.0, 1e-4);
  metres.unit = "ft";
  EXPECT_NEAR(Open(metres)->GroundHeightM({47.418, 8.503}).value(), 304.8, 1e-4);
}

TEST_F(GeotiffDemTest, KnowsUnitsHoweverTheyAreWrittenAndNamesThoseItDoesNotKnow) {
  Model model;
  model.height = [](double, double) { return 1000.0; };
  for (const auto& [unit, metres] :
       {std::pair{"Feet", 304.8}, std::pair{"Foot_US", 304.8006096}, std::pair{"Metre", 1000.0}}) {
    model.unit = unit;
    const auto dem = Open(model);
    EXPECT_NEAR(dem->GroundHeightM({47.418, 8.503}).value(), metres, 1e-4) << unit;
    EXPECT_EQ(dem->unknown_unit(), "") << unit;
  }
  model.unit = "fathom";
  const auto unknown = Open(model);
  EXPECT_NEAR(unknown->GroundHeightM({47.418, 8.503}).value(), 1000.0, 1e-4);
  EXPECT_EQ(unknown->unknown_unit(), "fathom");
}

// Heights above the ellipsoid become heights above the sea, as all other models have them.
TEST_F(GeotiffDemTest, TakesTheGeoidOffEllipsoidalHeights) {
  Model above_sea;
  above_sea.height = [](double, double) { return 450.0; };
  Model above_ellipsoid = above_sea;
  above_ellipsoid.epsg = 4979;
  const double sea_m = Open(above_sea)->GroundHeightM({47.418, 8.503}).value();
  const double ellipsoid_m = Open(above_ellipsoid)->GroundHeightM({47.418, 8.503}).value();
  EXPECT_NEAR(sea_m, 450.0, 1e-6);
  // The geoid lies 46 to 49 m above the ellipsoid there.
  EXPECT_GT(sea_m - ellipsoid_m, 45.0);
  EXPECT_LT(sea_m - ellipsoid_m, 50.0);
}

// With eastings too, where the key of the vertical system names one above the ellipsoid (GeoTIFF 1.1).
TEST_F(GeotiffDemTest, TakesTheGeoidOffEllipsoidalHeightsInMetres) {
  Model model;
  model.epsg = 32632;
  model.west = 461'000.0;
  model.north = 5'253'000.0;
  model.cell = 50.0;
  model.vertical_epsg = 5773;  // EGM96
  model.height = [](double, double) { return 450.0; };
  const std::filesystem::path path = Write(model);
  const auto height_m = [&] { return (*GeotiffDem::Open(path))->GroundHeightM({47.418, 8.503}).value(); };
  EXPECT_NEAR(height_m(), 450.0, 1e-6);
  // Which GDAL does not write: EPSG:4979 instead of EPSG:5773.
  const std::string above_sea("\x00\x10\x00\x00\x01\x00\x8d\x16", 8);
  std::string bytes = *ReadWholeFile(path);
  const std::size_t at = bytes.find(above_sea);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at + 6, 2, "\x73\x13");
  ASSERT_TRUE(WriteFileAtomically(path, bytes));
  EXPECT_GT(450.0 - height_m(), 45.0);
  EXPECT_LT(450.0 - height_m(), 50.0);
}

TEST_F(GeotiffDemTest, IsKnownAmongAFlightsFilesByItsBandAndItsPlace) {
  const auto is_model = [&](GDALDataType type, bool with_place) {
    Model model;
    model.type = type;
    model.height = [](double, double) { return 7.0; };
    const auto source = flight::OpenFileBytes(Write(model, with_place));
    return flight::IsElevationModel(**source);
  };
  EXPECT_TRUE(is_model(GDT_Float32, true));
  EXPECT_TRUE(is_model(GDT_Float64, true));
  EXPECT_TRUE(is_model(GDT_Int16, true));
  EXPECT_FALSE(is_model(GDT_Float32, false)) << "a picture that does not say where it lies";
  EXPECT_FALSE(is_model(GDT_UInt16, true)) << "a thermal picture";
  EXPECT_FALSE(is_model(GDT_Byte, true)) << "a map";
  const std::vector<std::uint8_t> photo{0xFF, 0xD8, 0xFF, 0xE1};
  flight::MemoryBytes jpeg(photo);
  EXPECT_FALSE(flight::IsElevationModel(jpeg));
}

TEST_F(GeotiffDemTest, RefusesWhatIsNoModelWithAdvice) {
  EXPECT_EQ(GeotiffDem::Open("/nowhere/model.tif").error().code, ErrorCode::kNotFound);
  Model model;
  model.height = [](double, double) { return 1.0; };
  const Error placeless = test::ErrorOf(GeotiffDem::Open(Write(model, false)));
  EXPECT_EQ(placeless.code, ErrorCode::kUnsupportedFormat);
  EXPECT_NE(placeless.message.find("where on Earth"), std::string::npos);
  const std::filesystem::path cut = Write(model);
  std::filesystem::resize_file(cut, 60);
  EXPECT_FALSE(GeotiffDem::Open(cut).ok());
}

}  // namespace
}  // namespace skyquilt::storage
