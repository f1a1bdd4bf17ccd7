// A map of others among the files of a job: what errors call it, and that it takes no more room than there
// is.
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <gmock/gmock.h>
#include <ogr_spatialref.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/geo/tile_id.h"
#include "server/imports/import_map.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/cog_writer.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "tests/storage/painted_tileset.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Where a picture lies: its system, its north-west corner and the side of a pixel.
struct PlaceOfPicture {
  int epsg = 32632;
  double west = 500'000.0, north = 5'200'000.0, pixel = 0.05;
};

// Noise, whose tiles take as many bytes as tiles can. 5 cm pixels in UTM 32 N if nothing else is said; or
// nowhere.
flight::InputFile WriteNoise(const std::filesystem::path& folder, int side_px,
                             const std::optional<PlaceOfPicture>& place) {
  GDALAllRegister();
  const std::filesystem::path path = folder / "0k2j";  // as a server stores it
  const std::unique_ptr<GDALDataset> file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), side_px, side_px, 3, GDT_Byte, nullptr));
  if (place) {
    OGRSpatialReference system;
    system.importFromEPSG(place->epsg);
    double corner[6] = {place->west, place->pixel, 0.0, place->north, 0.0, -place->pixel};
    file->SetGeoTransform(corner);
    file->SetSpatialRef(&system);
  }
  std::mt19937 random(7);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(side_px));
  for (int band = 1; band <= 3; ++band) {
    for (int y = 0; y < side_px; ++y) {
      for (std::uint8_t& value : row) value = static_cast<std::uint8_t>(random());
      EXPECT_EQ(file->GetRasterBand(band)->RasterIO(GF_Write, 0, y, side_px, 1, row.data(), side_px, 1,
                                                    GDT_Byte, 0, 0, nullptr),
                CE_None);
    }
  }
  return {"field.tif", path};
}

Result<pipeline::MosaicReport> Import(const flight::InputFile& file, const std::string& wanted,
                                      const ImportJob& job) {
  pipeline::MosaicOptions options;
  options.import_file = wanted;
  options.title = "Field";
  SilentProgress progress;
  return ImportForJob({{"other.tif", "/nowhere"}, file}, options, job, progress);
}

// Two tiles on either side of the antimeridian, and what the file says that it covers.
flight::InputFile WriteTilesAcross(const std::filesystem::path& folder, const geo::LatLonBounds& bounds) {
  const std::filesystem::path path = folder / "fiji";
  const auto writer = *storage::MbtilesWriter::Create(path);
  const auto tile = *pyramid::EncodeTile(test::PaintedTile({12, 256, 0, 0, 3, 3}, 1, 1), {});
  for (const int column : {0, (1 << 12) - 1}) {
    EXPECT_TRUE(writer->Put(*geo::TileId::Make(12, column, 2243), tile.format, tile.bytes).ok());
  }
  storage::TilesetMetadata metadata;
  metadata.bounds = bounds;
  metadata.min_zoom = metadata.max_zoom = 12;
  metadata.tile_size_px = 256;
  EXPECT_TRUE(writer->Publish(metadata).ok());
  return {"fiji.mbtiles", path};
}

TEST(ImportForJob, TilesAcrossTheAntimeridianAreOneMap) {
  constexpr double kTileDeg = 360.0 / (1 << 12);
  struct Case {
    geo::LatLonBounds said;
    double west_deg, east_deg;
  };
  for (const Case& one : {Case{{-180.0, -85.0, 180.0, 85.0}, 180.0 - kTileDeg, 180.0 + kTileDeg},
                          Case{{179.95, -17.0, 180.03, -16.0}, 179.95, 180.03},
                          Case{{-180.05, -17.0, -179.97, -16.0}, 179.95, 180.03},
                          Case{{179.95, -17.0, -179.97, -16.0}, 179.95, 180.03}}) {
    const test::TemporaryFolder in, out;
    const auto report =
        test::ValueOf(Import(WriteTilesAcross(in.path(), one.said), "fiji.mbtiles", {out.path(), true}));
    EXPECT_NEAR(report.bounds.west_deg, one.west_deg, 1e-9) << one.said.west_deg;
    EXPECT_NEAR(report.bounds.east_deg, one.east_deg, 1e-9) << one.said.west_deg;
  }
}

std::string GreyJpeg(int value) {
  GDALAllRegister();
  constexpr const char* kName = "/vsimem/grey.jpg";
  GDALDriverManager& drivers = *GetGDALDriverManager();
  const std::unique_ptr<GDALDataset> grey(
      drivers.GetDriverByName("MEM")->Create("", 256, 256, 1, GDT_Byte, nullptr));
  EXPECT_EQ(grey->GetRasterBand(1)->Fill(value), CE_None);
  std::unique_ptr<GDALDataset> written(
      drivers.GetDriverByName("JPEG")->CreateCopy(kName, grey.get(), FALSE, nullptr, nullptr, nullptr));
  EXPECT_NE(written, nullptr);
  written.reset();
  vsi_l_offset length = 0;
  const GByte* const bytes = VSIGetMemFileBuffer(kName, &length, FALSE);
  const std::string jpeg(reinterpret_cast<const char*>(bytes), length);
  VSIUnlink(kName);
  return jpeg;
}

// As MBTiles of hillshades have them.
TEST(ImportForJob, TilesOfGreyJpegAreInTheGeotiffToo) {
  const test::TemporaryFolder in, out;
  const flight::InputFile file{"hills.mbtiles", in.path() / "0k2j"};
  const std::string grey = GreyJpeg(90);
  const auto writer = *storage::MbtilesWriter::Create(file.path);
  for (const int column : {68'000, 68'001}) {
    ASSERT_TRUE(writer
                    ->Put(*geo::TileId::Make(17, column, 46'175), image::PictureFormat::kJpeg,
                          {reinterpret_cast<const std::uint8_t*>(grey.data()), grey.size()})
                    .ok());
  }
  storage::TilesetMetadata metadata;
  metadata.bounds = {-180.0, -85.0, 180.0, 85.0};
  metadata.min_zoom = metadata.max_zoom = 17;
  ASSERT_TRUE(writer->Publish(metadata).ok());
  ASSERT_TRUE(Import(file, file.name, {out.path(), false}).ok());
  const std::filesystem::path tif = out.path() / "mosaic.tif";
  SilentProgress progress;
  ASSERT_TRUE(storage::WriteCog(out.path() / "mosaic.mbtiles", tif, {}, progress).ok());
  const std::unique_ptr<GDALDataset> map(GDALDataset::Open(tif.c_str()));
  ASSERT_NE(map, nullptr);
  std::uint8_t pixel = 0;
  ASSERT_EQ(map->GetRasterBand(3)->RasterIO(GF_Read, 300, 100, 1, 1, &pixel, 1, 1, GDT_Byte, 0, 0, nullptr),
            CE_None);
  EXPECT_NEAR(pixel, 90, 2);
}

TEST(ImportForJob, MakesTheProductsOfAMap) {
  const test::TemporaryFolder in, out;
  const auto report =
      test::ValueOf(Import(WriteNoise(in.path(), 600, PlaceOfPicture{}), "field.tif", {out.path(), true}));
  EXPECT_EQ(report.title, "Field");
  EXPECT_THAT(InWords(report.warnings.at(0)), HasSubstr("imported from field.tif"));
  EXPECT_NEAR(report.area_m2, 900.0, 20.0);
  for (const char* name :
       {"mosaic.mbtiles", "mosaic.pmtiles", "thumbnail.png", "report.json", "photos.geojson"}) {
    EXPECT_TRUE(std::filesystem::exists(out.path() / name)) << name;
  }
}

void ChangeReport(const std::filesystem::path& folder, const std::string& what, const std::string& by) {
  std::string text = storage::ReadWholeFile(folder / "report.json").value();
  const std::size_t at = text.find(what);
  ASSERT_NE(at, std::string::npos) << what;
  ASSERT_TRUE(storage::WriteFileAtomically(folder / "report.json", text.replace(at, what.size(), by)));
}

// 180 degrees lie at 819,451.6 m east of UTM 60 S there.
TEST(ImportForJob, NamesAPictureThatCrossesTheAntimeridian) {
  const auto why_not = [](const PlaceOfPicture& place) {
    const test::TemporaryFolder in, out;
    const auto made = Import(WriteNoise(in.path(), 400, place), "field.tif", {out.path(), false});
    if (made) return std::string("made");
    return std::string(flight::NameOf(flight::WhyOf(made.error()).code));
  };
  EXPECT_EQ(why_not({4326, 179.9998, -17.0, 1e-6}), "import_across_antimeridian");
  EXPECT_EQ(why_not({4326, -180.0002, -17.0, 1e-6}), "import_across_antimeridian");
  EXPECT_EQ(why_not({32760, 819'441.0, 8'118'000.0, 0.05}), "import_across_antimeridian");
  EXPECT_EQ(why_not({4326, 179.9995, -17.0, 1e-6}), "made");
  EXPECT_EQ(why_not({32760, 819'400.0, 8'118'000.0, 0.05}), "made");
}

TEST(ImportForJob, TakesTheQualityThatTheMapsOwnReportStates) {
  const test::TemporaryFolder in, first;
  const auto made =
      test::ValueOf(Import(WriteNoise(in.path(), 600, PlaceOfPicture{}), "field.tif", {first.path(), false}));
  EXPECT_EQ(made.quality.status, pipeline::MapStatus::kUnknown) << "nobody says how true it is";
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), R"("status": "unknown")", R"("status": "ready")"));
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), R"("sigma_m": null)", R"("sigma_m": 2.3)"));
  const auto again = [&](const std::string& name_of_report) {
    const test::TemporaryFolder out;
    pipeline::MosaicOptions options;
    options.import_file = "maps/field.mbtiles";
    SilentProgress progress;
    const auto report = ImportForJob({{"maps/field.mbtiles", first.path() / "mosaic.mbtiles"},
                                      {name_of_report, first.path() / "report.json"}},
                                     options, {out.path(), false}, progress);
    EXPECT_TRUE(report.ok()) << report.error().message;
    return report->quality;
  };
  EXPECT_EQ(again("maps/report.json").status, pipeline::MapStatus::kReady);
  EXPECT_EQ(again("maps/report.json").absolute.sigma_m, std::optional(2.3));
  EXPECT_EQ(again("report.json").status, pipeline::MapStatus::kUnknown) << "of another folder";
  const std::string deep = R"("deep": )" + std::string(300'000, '[') + std::string(300'000, ']') + ",";
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), R"("quality": {)", R"("quality": {)" + deep));
  EXPECT_EQ(again("maps/report.json").status, pipeline::MapStatus::kUnknown) << "nested without end";
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), deep, ""));
  EXPECT_EQ(again("maps/report.json").status, pipeline::MapStatus::kReady);
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), R"("tile_count": )", R"("tile_count": 1)"));
  EXPECT_EQ(again("maps/report.json").status, pipeline::MapStatus::kUnknown) << "of another map";
  ASSERT_NO_FATAL_FAILURE(ChangeReport(first.path(), "{", "["));
  EXPECT_EQ(again("maps/report.json").status, pipeline::MapStatus::kUnknown) << "damaged";
}

TEST(ImportForJob, CallsAFileByItsNameAndNotByWhereItIs) {
  const test::TemporaryFolder in, out;
  const flight::InputFile nowhere = WriteNoise(in.path(), 64, std::nullopt);
  const Error refused = test::ErrorOf(Import(nowhere, "field.tif", {out.path(), false}));
  EXPECT_EQ(refused.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(refused.message, HasSubstr("field.tif is not georeferenced"));
  EXPECT_EQ(flight::WhyOf(refused).code, flight::RemarkCode::kImportNotGeoreferenced);
  EXPECT_THAT(refused.message, Not(HasSubstr(in.path().string())));
  const Error missing = test::ErrorOf(Import(nowhere, "gone.tif", {out.path(), false}));
  EXPECT_THAT(missing.message, HasSubstr("no file \"gone.tif\""));
}

TEST(ImportForJob, SaysByACodeWhyTilesAreNoMap) {
  const test::TemporaryFolder in;
  const auto why_not = [&](const std::string& change) {
    const test::TemporaryFolder out;
    const flight::InputFile file{"field.mbtiles", in.path() / "0k2j"};
    std::filesystem::remove(file.path);
    test::WritePaintedTileset(file.path, {17, 256, 68125, 46175, 3, 3});
    EXPECT_TRUE((*storage::SqliteDb::Open(file.path, storage::OpenMode::kReadWriteCreate)).Exec(change));
    const auto made = Import(file, file.name, {out.path(), false});
    if (made) return std::string("made");
    EXPECT_THAT(made.error().message, HasSubstr("field.mbtiles"));
    return std::string(flight::NameOf(flight::WhyOf(made.error()).code));
  };
  EXPECT_EQ(why_not("SELECT 1"), "made");
  EXPECT_EQ(why_not("UPDATE metadata SET value='pbf' WHERE name='format'"), "import_vector_tiles");
  EXPECT_EQ(why_not("INSERT INTO metadata(name, value) VALUES('scheme', 'xyz')"), "import_rows_from_north");
  EXPECT_EQ(why_not("INSERT INTO metadata(name, value) VALUES('crs', 'EPSG:2056')"), "import_other_system");
  EXPECT_EQ(why_not("DROP TABLE metadata"), "import_no_mbtiles");
  // A picture with 32 MiB behind its end: each request for it would take as much of the server's memory.
  EXPECT_EQ(why_not("UPDATE tiles_data SET tile_data=CAST(tile_data || zeroblob(33554432) AS BLOB)"
                    " WHERE tile_data_id=(SELECT min(tile_data_id) FROM tiles_data)"),
            "import_tile_damaged");
}

TEST(ImportForJob, TakesNoMoreOfAnAttributionThanAnybodyReads) {
  const test::TemporaryFolder in, out;
  const flight::InputFile file{"field.mbtiles", in.path() / "0k2j"};
  test::WritePaintedTileset(file.path, {17, 256, 68125, 46175, 3, 3});
  ASSERT_TRUE((*storage::SqliteDb::Open(file.path, storage::OpenMode::kReadWriteCreate))
                  .Exec("INSERT OR REPLACE INTO metadata VALUES('attribution', hex(zeroblob(3000000)))"));
  ASSERT_TRUE(Import(file, file.name, {out.path(), false}).ok());
  const auto made = *storage::MbtilesReader::Open(out.path() / "mosaic.mbtiles");
  EXPECT_EQ(storage::TilesetText(made->metadata(), "attribution"), std::string(4096, '0'));
}

TEST(ImportForJob, EndsWhereTheDiskHasNoRoomForTheMap) {
  const test::TemporaryFolder in, out;
  const flight::InputFile file = WriteNoise(in.path(), 4096, PlaceOfPicture{});
  constexpr rlim_t kRoomBytes = rlim_t{5} << 20;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit limited{kRoomBytes, before.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  const auto full = Import(file, "field.tif", {out.path(), false});
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  signal(SIGXFSZ, handler);
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::kOutOfSpace) << full.error().message << full.error().detail;
}

}  // namespace
}  // namespace skyquilt::server
