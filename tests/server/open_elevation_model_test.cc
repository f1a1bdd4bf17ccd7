// Which elevation model a flight is given, and that a bad one among its files costs a warning and not the
// map.
#include "server/inputs/open_elevation_model.h"

#include <gdal_priv.h>
#include <gmock/gmock.h>
#include <ogr_spatialref.h>

#include "core/flight/remarks/remark_words.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// 300 m everywhere in a tenth of a degree about 47.4, 8.5; in an unplaced site grid it cannot be used.
flight::InputFile WriteModel(const std::filesystem::path& folder, const std::string& name, bool is_placed,
                             const char* unit = "") {
  GDALAllRegister();
  OGRSpatialReference system;
  if (is_placed) {
    system.importFromEPSG(4326);
  } else {
    system.SetLocalCS("site grid");
  }
  const std::unique_ptr<GDALDataset> file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      (folder / name).c_str(), 10, 10, 1, GDT_Float32, nullptr));
  double corner[6] = {8.45, 0.01, 0.0, 47.45, 0.0, -0.01};
  file->SetGeoTransform(corner);
  file->SetSpatialRef(&system);
  file->GetRasterBand(1)->SetUnitType(unit);
  EXPECT_EQ(file->GetRasterBand(1)->Fill(300.0), CE_None);
  return {name, folder / name};
}

TEST(OpenElevationModel, TakesTheFirstThatCanBeReadAndWarnsOfTheOthers) {
  const test::TemporaryFolder folder;
  const flight::InputFile bad = WriteModel(folder.path(), "a.tif", false);
  const flight::InputFile good = WriteModel(folder.path(), "b.tif", true);
  const auto both = test::ValueOf(OpenElevationModel("", {bad, good}));
  ASSERT_NE(both.source, nullptr);
  EXPECT_NEAR(both.source->GroundHeightM({47.4, 8.5}).value_or(0.0), 300.0, 1e-3);
  EXPECT_THAT(InWords(both.warnings), ElementsAre(HasSubstr("a.tif is not used")));

  const auto none = test::ValueOf(OpenElevationModel("", {bad}));
  EXPECT_EQ(none.source, nullptr);
  EXPECT_THAT(InWords(none.warnings), ElementsAre(HasSubstr("a.tif is not used")));
}

TEST(OpenElevationModel, SaysThatAnUnknownUnitCountsAsMetres) {
  const test::TemporaryFolder folder;
  const flight::InputFile model = WriteModel(folder.path(), "a.tif", true, "fathom");
  const auto among = test::ValueOf(OpenElevationModel("", {model}));
  EXPECT_THAT(InWords(among.warnings), ElementsAre(HasSubstr("a.tif states its heights in a unit")));
  EXPECT_THAT(InWords(among.warnings), ElementsAre(HasSubstr("\"fathom\"")));
  const auto given = test::ValueOf(OpenElevationModel(model.path.string(), {}));
  EXPECT_THAT(InWords(given.warnings), ElementsAre(HasSubstr("\"fathom\"")));
}

// A block of 256 MiB in a file of a few kB: none of it was ever written.
TEST(OpenElevationModel, RefusesBlocksThatAreTooLargeToBeRead) {
  GDALAllRegister();
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.tif";
  OGRSpatialReference system;
  system.importFromEPSG(4326);
  const char* const options[] = {"COMPRESS=DEFLATE", "SPARSE_OK=TRUE", "BLOCKYSIZE=8192", nullptr};
  {
    const std::unique_ptr<GDALDataset> file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        path.c_str(), 8192, 8192, 1, GDT_Float32, options));
    double corner[6] = {8.45, 1e-5, 0.0, 47.45, 0.0, -1e-5};
    file->SetGeoTransform(corner);
    file->SetSpatialRef(&system);
  }
  ASSERT_LT(std::filesystem::file_size(path), 100'000U);
  const auto given = test::ValueOf(OpenElevationModel("", {{"a.tif", path}}));
  EXPECT_EQ(given.source, nullptr);
  EXPECT_THAT(InWords(given.warnings), ElementsAre(HasSubstr("blocks of 256 MiB")));
}

TEST(OpenElevationModel, RefusesTheOneThatWasAskedFor) {
  const test::TemporaryFolder folder;
  const flight::InputFile bad = WriteModel(folder.path(), "a.tif", false);
  const flight::InputFile good = WriteModel(folder.path(), "b.tif", true);
  EXPECT_FALSE(OpenElevationModel(bad.path.string(), {good}).ok());
  const auto named = test::ValueOf(OpenElevationModel(good.path.string(), {bad}));
  EXPECT_THAT(InWords(named.warnings), ElementsAre(HasSubstr("a.tif"))) << "it is not used, and that is said";
}

}  // namespace
}  // namespace skyquilt::server
