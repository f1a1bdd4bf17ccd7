#include "storage/exports/custom/export_map.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string_view>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "storage/db/sqlite_db.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/custom/target_crs.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "tests/storage/painted_tileset.h"
#include "tests/storage/rasters/band_file.h"
#include "tests/storage/rasters/raster_by_gdal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kZoom = 19;
constexpr int kFirstColumn = 272500, kFirstRow = 184700, kTiles = 4;

geo::LatLonBounds BoundsOf(double west_tiles, double north_tiles, double east_tiles, double south_tiles) {
  const double tile_m = geo::TileSizeInMercM(kZoom);
  const auto place = [&](double column, double row) {
    return geo::LatLonFromMerc({(kFirstColumn + column) * tile_m - geo::kMercHalfWidthM,
                                geo::kMercHalfWidthM - (kFirstRow + row) * tile_m});
  };
  const geo::LatLon north_west = place(west_tiles, north_tiles), south_east = place(east_tiles, south_tiles);
  return {north_west.lon_deg, south_east.lat_deg, south_east.lon_deg, north_west.lat_deg};
}

std::string BoxText(const geo::LatLonBounds& box) {
  const auto& [w, s, e, n] = box;
  return fmt::format(
      R"({{"type":"Polygon","coordinates":[[[{0:.12f},{1:.12f}],[{2:.12f},{1:.12f}],[{2:.12f},{3:.12f}],[{0:.12f},{3:.12f}],[{0:.12f},{1:.12f}]]]}})",
      w, s, e, n);
}

class ExportMapTest : public testing::Test {
 protected:
  ExportMapTest() {
    RegisterGdalOnce();
    fs::create_directory(folder_.path() / "map");
    fs::create_directory(folder_.path() / "work");
    const fs::path tiles = folder_.path() / "map" / "mosaic.mbtiles";
    test::WritePaintedTileset(tiles, {kZoom, 256, kFirstColumn, kFirstRow, kTiles, kTiles});
    const auto& [w, s, e, n] = BoundsOf(0, 0, kTiles, kTiles);
    auto db = *SqliteDb::Open(tiles, OpenMode::kReadWriteCreate);
    EXPECT_TRUE(db.Exec(fmt::format(
        "UPDATE metadata SET value='{:.12f},{:.12f},{:.12f},{:.12f}' WHERE name='bounds'", w, s, e, n)));
    std::ofstream(folder_.path() / "map" / "report.json") << R"({"gsd_m":0.25,"is_placed":true})";
  }

  Result<void> Export(const std::string& wish, const std::string& name) {
    const auto request = ParseExportRequest(wish);
    if (!request) return request.error();
    const auto source = ExportSourceOf(folder_.path() / "map");
    if (!source) return source.error();
    SilentProgress progress;
    const auto made = ExportMap(*source, *request, folder_.path() / "work", Out(name), {85, 1}, progress);
    EXPECT_TRUE(fs::is_empty(folder_.path() / "work")) << wish;
    return made;
  }
  void ExportWell(const std::string& wish, const std::string& name) {
    const auto made = Export(wish, name);
    ASSERT_TRUE(made.ok()) << wish << " " << made.error().message << made.error().detail;
  }
  Error Refused(const std::string& wish) {
    const auto made = Export(wish, "refused");
    EXPECT_FALSE(made.ok()) << wish;
    EXPECT_FALSE(fs::exists(Out("refused")));
    return made ? Error{} : made.error();
  }
  std::string Refusal(const std::string& wish) { return Refused(wish).message; }
  // What the page says in its own language.
  std::string_view Reason(const std::string& wish) {
    return flight::NameOf(flight::WhyOf(Refused(wish)).code);
  }
  fs::path Out(const std::string& name) const { return folder_.path() / name; }
  std::unique_ptr<GDALDataset> Open(const std::string& name) const { return test::OpenByGdal(Out(name)); }
  // Red and near infrared, so many tiles south-east of the map's corner.
  void WriteBands(int tiles, int width_px, int height_px, std::function<float(int, int, int)> value) const {
    const double tile_m = geo::TileSizeInMercM(kZoom);
    const double west_m = (kFirstColumn + tiles) * tile_m - geo::kMercHalfWidthM;
    const double north_m = geo::kMercHalfWidthM - (kFirstRow + tiles) * tile_m;
    const std::vector<std::string> bands{"red", "nir"};
    test::WriteBandFile(Out("map") / "bands.tif",
                        {west_m, north_m, tile_m / 256, width_px, height_px, bands, std::move(value)});
  }
  test::TemporaryFolder folder_;
};

TEST_F(ExportMapTest, WhatIsAskedForAsItIsIsTheMapsOwnBytes) {
  ExportWell(R"({"format":"mbtiles"})", "all.mbtiles");
  EXPECT_EQ(*ReadWholeFile(Out("all.mbtiles")), *ReadWholeFile(Out("map") / "mosaic.mbtiles"));
  ExportWell(R"({"format":"geotiff"})", "made.tif");
  SilentProgress progress;
  ASSERT_TRUE(WriteCog(Out("map") / "mosaic.mbtiles", Out("map") / "mosaic.tif", {}, progress));
  ExportWell(R"({"format":"geotiff"})", "copied.tif");
  EXPECT_EQ(*ReadWholeFile(Out("copied.tif")), *ReadWholeFile(Out("made.tif")));
  ExportWell(R"({"format":"pmtiles"})", "all.pmtiles");
  EXPECT_EQ(ReadWholeFile(Out("all.pmtiles"))->substr(0, 7), "PMTiles");
  ExportWell(R"({"format":"kmz"})", "all.kmz");
  EXPECT_EQ(ReadWholeFile(Out("all.kmz"))->substr(0, 2), "PK");
}

TEST_F(ExportMapTest, ABoundaryCutsAtItsPixelsAndLeavesWholeTilesAsTheyAre) {
  // From the middle of the second tile to the end of the third, both ways.
  const geo::LatLonBounds box = BoundsOf(1.5, 1.0, 3.0, 3.0);
  ExportWell(R"({"format":"mbtiles","boundary":)" + BoxText(box) + "}", "cut.mbtiles");
  const auto whole = *MbtilesReader::Open(Out("map") / "mosaic.mbtiles");
  const auto cut = *MbtilesReader::Open(Out("cut.mbtiles"));
  const auto tile = [](MbtilesReader& reader, int column, int row) -> std::string {
    const auto found = *reader.Find(*geo::TileId::Make(kZoom, kFirstColumn + column, kFirstRow + row));
    return found ? *reader.Load(*found) : "";
  };
  EXPECT_EQ(tile(*cut, 0, 1), "");
  EXPECT_EQ(tile(*cut, 3, 1), "");
  EXPECT_EQ(tile(*cut, 2, 0), "");
  ASSERT_NE(tile(*whole, 2, 1), "");
  EXPECT_EQ(tile(*cut, 2, 1), tile(*whole, 2, 1));
  const auto before = image::DecodePicture(tile(*whole, 1, 2)),
             after = image::DecodePicture(tile(*cut, 1, 2));
  ASSERT_TRUE(before.ok() && after.ok());
  for (int y = 0; y < 256; y += 5) {
    for (int x = 0; x < 256; x += 3) {
      if (x < 128) {
        EXPECT_EQ(after->Pixel(x, y)[3], 0) << x << "," << y;
      } else if (before->Pixel(x, y)[3] == 255) {
        EXPECT_EQ(after->Pixel(x, y)[3], 255) << x << "," << y;
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(after->Pixel(x, y)[c], before->Pixel(x, y)[c], 24) << x << "," << y;
      }
    }
  }
  const auto facts = test::ValueOf(FactsOfTileset(cut->metadata()));
  EXPECT_NEAR(facts.bounds.west_deg, box.west_deg, 1e-9);
  EXPECT_NEAR(facts.bounds.north_deg, box.north_deg, 1e-9);
}

TEST_F(ExportMapTest, TilesGoDownToTheResolutionAskedFor) {
  // 0.2 m a pixel at this latitude and zoom; twice that is one zoom less.
  ExportWell(R"({"format":"pmtiles","resolution_m":0.45})", "coarse.pmtiles");
  ExportWell(R"({"format":"mbtiles","resolution_m":0.45})", "coarse.mbtiles");
  const auto facts = test::ValueOf(FactsOfTileset((*MbtilesReader::Open(Out("coarse.mbtiles")))->metadata()));
  EXPECT_EQ(facts.max_zoom, kZoom - 1);
  EXPECT_LT(fs::file_size(Out("coarse.mbtiles")), fs::file_size(Out("map") / "mosaic.mbtiles"));
}

TEST_F(ExportMapTest, AGeotiffHasTheSystemResolutionAndAreaAskedFor) {
  const geo::LatLonBounds box = BoundsOf(1.0, 1.0, 3.0, 3.0);
  ExportWell(R"({"format":"geotiff","crs":"EPSG:2056","resolution_m":0.5,"boundary":)" + BoxText(box) + "}",
             "ch.tif");
  const auto made = Open("ch.tif");
  EXPECT_STREQ(made->GetSpatialRef()->GetAuthorityCode(nullptr), "2056");
  const auto from = test::TransformOf(*made);
  EXPECT_NEAR(from[1], 0.5, 1e-9);
  EXPECT_NEAR(from[5], -0.5, 1e-9);
  // Two tiles of 256 pixels of 0.204 m, and what the box's turn in the other grid adds.
  EXPECT_NEAR(made->GetRasterXSize(), 2 * 256 * 0.2045 / 0.5, 8);
  EXPECT_NEAR(made->GetRasterYSize(), 2 * 256 * 0.2045 / 0.5, 8);
  // What lies in the middle of the map lies in the middle of the export.
  ExportWell(R"({"format":"geotiff"})", "merc.tif");
  const auto merc_map = Open("merc.tif");
  const auto merc = test::TransformOf(*merc_map);
  const std::unique_ptr<OGRCoordinateTransformation> transform(
      OGRCreateCoordinateTransformation(made->GetSpatialRef(), merc_map->GetSpatialRef()));
  for (int at = 20; at < 190; at += 17) {
    double x = from[0] + (at + 0.5) * from[1], y = from[3] + (at + 0.5) * from[5];
    ASSERT_TRUE(transform->Transform(1, &x, &y));
    for (int band = 1; band <= 3; ++band) {
      const int wanted =
          test::PixelAt(*merc_map->GetRasterBand(band), static_cast<int>((x - merc[0]) / merc[1]),
                        static_cast<int>((y - merc[3]) / merc[5]));
      EXPECT_NEAR(test::PixelAt(*made->GetRasterBand(band), at, at), wanted, 12) << at;
    }
  }
}

TEST_F(ExportMapTest, UtmAndDegreesWork) {
  ExportWell(R"({"format":"geotiff","crs":"utm"})", "utm.tif");
  EXPECT_NEAR(test::TransformOf(*Open("utm.tif"))[1], 0.25, 1e-9);  // the photos' own: nothing finer was seen
  ExportWell(R"({"format":"geotiff","crs":"EPSG:4326","resolution_m":0.3})", "degrees.tif");
  const auto from = test::TransformOf(*Open("degrees.tif"));
  EXPECT_NEAR(from[1] * 111320 * std::cos(46.8 * M_PI / 180), 0.3, 0.002);
  EXPECT_NEAR(-from[5] * 111180, 0.3, 0.002);
}

std::vector<float> ValuesIn(GDALDataset& file) { return test::PixelsOf<float>(*file.GetRasterBand(1)); }

TEST_F(ExportMapTest, AnIndexHasTheValuesOfThePixels) {
  ExportWell(R"({"format":"geotiff","expression":"red-0.5"})", "red.tif");
  const auto file = Open("red.tif");
  constexpr int kSide = kTiles * 256;
  ASSERT_EQ(file->GetRasterXSize(), kSide);
  ASSERT_EQ(file->GetRasterYSize(), kSide);
  EXPECT_EQ(file->GetRasterBand(1)->GetRasterDataType(), GDT_Float32);
  EXPECT_STREQ(file->GetRasterBand(1)->GetDescription(), "red-0.5");
  EXPECT_GT(file->GetRasterBand(1)->GetOverviewCount(), 0);
  const std::vector<float> values = ValuesIn(*file);
  const auto reader = *MbtilesReader::Open(Out("map") / "mosaic.mbtiles");
  int known = 0, unknown = 0;
  for (int row = 0; row < kTiles; ++row) {
    for (int column = 0; column < kTiles; ++column) {
      const auto found = *reader->Find(*geo::TileId::Make(kZoom, kFirstColumn + column, kFirstRow + row));
      const auto tile =
          found ? *image::DecodePicture(*reader->Load(*found))
                : image::RgbaImage{256, 256, decltype(image::RgbaImage::rgba)(std::size_t{4} * 256 * 256, 0)};
      for (int y = 0; y < 256; y += 7) {
        for (int x = 0; x < 256; x += 5) {
          const float value = values[static_cast<std::size_t>((row * 256 + y) * kSide + column * 256 + x)];
          const auto* pixel = tile.Pixel(x, y);
          const bool is_known = pixel[3] >= 128;
          ASSERT_EQ(std::isnan(value), !is_known) << column << "," << row << " " << x << "," << y;
          if (is_known) {
            ASSERT_NEAR(value, pixel[0] / 255.0 - 0.5, 1e-6);
          }
          ++(is_known ? known : unknown);
        }
      }
    }
  }
  EXPECT_GT(known, 1000);
  EXPECT_GT(unknown, 100) << "the map is round";
}

TEST_F(ExportMapTest, AnIndexIsCutAndBroughtToOtherSystems) {
  const geo::LatLonBounds box = BoundsOf(1.5, 1.0, 3.0, 3.0);
  ExportWell(R"({"format":"geotiff","expression":"0*red+7","crs":"utm","resolution_m":0.5,"boundary":)" +
                 BoxText(box) + "}",
             "cut.tif");
  const auto file = Open("cut.tif");
  const auto from = test::TransformOf(*file);
  EXPECT_NEAR(from[1], 0.5, 1e-9);
  double square_m = 0.0;
  for (const float value : ValuesIn(*file)) {
    if (std::isnan(value)) continue;
    EXPECT_NEAR(value, 7.0, 1e-5);
    square_m += 0.25;
  }
  const double ground = geo::GroundMetresPerMercMetre(box.Middle().lat_deg);
  const double tile_m = geo::TileSizeInMercM(kZoom) * ground;
  EXPECT_NEAR(square_m, 1.5 * 2.0 * tile_m * tile_m, 0.03 * 3.0 * tile_m * tile_m);
}

TEST_F(ExportMapTest, AnIndexOfBandsComesFromTheirFile) {
  EXPECT_NE(Refusal(R"({"format":"geotiff","index":"ndvi"})").find("no band \"nir\""), std::string::npos);
  WriteBands(1, 300, 200, [](int band, int column, int row) {
    if (column < 10) return std::nanf("");
    return band == 0 ? 0.1f : 0.1f + 0.001f * static_cast<float>(row);
  });
  ExportWell(R"({"format":"geotiff","index":"ndvi"})", "ndvi.tif");
  const auto file = Open("ndvi.tif");
  EXPECT_STREQ(file->GetRasterBand(1)->GetDescription(), "NDVI");
  ASSERT_EQ(file->GetRasterXSize(), 300);
  ASSERT_EQ(file->GetRasterYSize(), 200);
  const std::vector<float> values = ValuesIn(*file);
  for (int row = 0; row < 200; row += 11) {
    EXPECT_TRUE(std::isnan(values[static_cast<std::size_t>(row * 300 + 5)]));
    const double nir = 0.1 + 0.001 * row;
    EXPECT_NEAR(values[static_cast<std::size_t>(row * 300 + 200)], (nir - 0.1) / (nir + 0.1), 1e-4) << row;
  }
}

TEST_F(ExportMapTest, NothingIsLostAtTheSidesWhereNorthLeans) {
  // Full to its corners, two degrees off the zone's middle meridian.
  constexpr int kSide = kTiles * 256;
  const double tile_m = geo::TileSizeInMercM(kZoom);
  WriteBands(0, kSide, kSide, [](int band, int, int) { return band == 0 ? 1.0f : 3.0f; });
  ExportWell(R"({"format":"geotiff","index":"ndvi","crs":"utm"})", "utm.tif");
  const auto file = Open("utm.tif");
  const auto from = test::TransformOf(*file);
  double square_m = 0.0;
  for (const float value : ValuesIn(*file)) {
    if (!std::isnan(value)) square_m += -from[1] * from[5];
  }
  const double side_m =
      kTiles * tile_m * geo::GroundMetresPerMercMetre(BoundsOf(0, 0, kTiles, kTiles).Middle().lat_deg);
  EXPECT_NEAR(square_m / (side_m * side_m), 1.0, 0.008);  // a pixel along each side, and the ellipsoid
}

TEST_F(ExportMapTest, WhatCannotBeIsRefusedWithWhatToDo) {
  EXPECT_EQ(Reason(R"({"format":"geotiff","crs":"EPSG:999999"})"), "export_system_unknown");
  EXPECT_EQ(Reason(R"({"format":"geotiff","crs":"EPSG:32610"})"), "export_system_elsewhere");
  EXPECT_NE(Refusal(R"({"format":"geotiff","crs":"EPSG:32610"})").find("the map lies at"), std::string::npos);
  EXPECT_EQ(Reason(R"({"format":"geotiff","crs":"EPSG:4978"})"), "export_system_no_plane");
  for (const char* compound : {"EPSG:25832+7837", "EPSG:5555", "urn:ogc:def:crs:EPSG::5555"}) {
    const std::string wish = std::string(R"({"format":"geotiff","crs":")") + compound + "\"}";
    EXPECT_EQ(Reason(wish), "export_system_compound") << compound;
    EXPECT_NE(Refusal(wish).find("EPSG:25832."), std::string::npos) << Refusal(wish);
  }
  EXPECT_EQ(*EpsgOf("urn:ogc:def:crs:EPSG::25832", {46.95, 7.44}), 25832);
  EXPECT_EQ(*EpsgOf("urn:ogc:def:crs:EPSG:9.9.1:25832", {46.95, 7.44}), 25832);
  EXPECT_FALSE(EpsgOf("urn:ogc:def:crs:EPSG:", {46.95, 7.44}));
  EXPECT_NE(Refusal(R"({"format":"geotiff","crs":"+proj=utm"})").find("EPSG:2056"), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"kmz","crs":"utm"})").find("Web Mercator"), std::string::npos);
  EXPECT_EQ(Reason(R"({"format":"geotiff","resolution_m":0.05})"), "export_finer_than_map");
  EXPECT_NE(Refusal(R"({"format":"geotiff","resolution_m":0.05})").find("a resolution of 0.05 m"),
            std::string::npos);
  EXPECT_EQ(Reason(R"({"format":"geotiff","resolution_m":5000})"), "export_beyond_map");
  EXPECT_NE(Refusal(R"({"format":"geotiff","resolution_m":-1})").find("above 0"), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"shp"})").find("\"kmz\""), std::string::npos);
  EXPECT_NE(Refusal(R"({})").find("Say the format"), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"report","crs":"utm"})").find("of the whole map"), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"kmz","index":"vari"})").find("take \"geotiff\""), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"geotiff","index":"vigour"})").find("\"expression\""), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"geotiff","expression":"red-"})").find("expression"), std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"geotiff","expression":"red","index":"vari"})").find("not both"),
            std::string::npos);
  EXPECT_NE(Refusal(R"({"format":"geotiff","expression":"red/0"})").find("no value anywhere"),
            std::string::npos);
  EXPECT_EQ(ExportFormatOfFile("map.pdf"), std::nullopt) << "a report is no form of the tiles";
  EXPECT_NE(Refusal(R"({"format":"kmz","color":1})").find("color"), std::string::npos);
  const std::string elsewhere = R"({"format":"kmz","boundary":)" + BoxText({1, 1, 2, 2}) + "}";
  EXPECT_EQ(Reason(elsewhere), "export_outside_map");
  EXPECT_NE(Refusal(elsewhere).find("which covers 46."), std::string::npos);
  // Within the map's box, but where the round map has no pixel.
  EXPECT_EQ(Reason(R"({"format":"mbtiles","boundary":)" + BoxText(BoundsOf(0, 0, 0.05, 0.05)) + "}"),
            "export_nothing_within");
  std::ofstream(Out("map") / "report.json") << R"({"gsd_m":0.25,"is_placed":false})";
  EXPECT_EQ(Reason(R"({"format":"geotiff","crs":"utm"})"), "export_without_place");
  ExportWell(R"({"format":"kmz"})", "unplaced.kmz");
  fs::remove(Out("map") / "mosaic.mbtiles");
  EXPECT_NE(Refusal(R"({"format":"kmz"})").find("no finished map"), std::string::npos);
}

// As maps of earlier versions have it: in degrees such an export went round the Earth without end.
TEST(FactsOfTileset, BoundsBeginOnEarth) {
  const auto facts =
      FactsOfTileset({{"minzoom", "12"}, {"maxzoom", "21"}, {"bounds", "-180.0006,-17.1,-179.9994,-17.0"}});
  ASSERT_TRUE(facts.ok()) << facts.error().message;
  EXPECT_NEAR(facts->bounds.west_deg, 179.9994, 1e-9);
  EXPECT_NEAR(facts->bounds.east_deg, 180.0006, 1e-9);
}

// GeoJSON counts from -180 on beyond 180 degrees, and cuts areas there.
TEST(Common, OfAMapOnTheAntimeridianAreasLieOnBothSides) {
  MapFacts map;
  map.bounds = {179.9994, -17.1, 180.0006, -17.0};
  const geo::LatLonBounds east = Common(map.bounds, {-179.9998, -17.08, -179.9996, -17.05});
  EXPECT_NEAR(east.west_deg, 180.0002, 1e-9);
  EXPECT_NEAR(east.east_deg, 180.0004, 1e-9);
  EXPECT_EQ(east.south_deg, -17.08);
  EXPECT_EQ(east.north_deg, -17.05);
  const geo::LatLonBounds both = Common(map.bounds, {-180.0, -18.0, 180.0, -16.0});
  EXPECT_EQ(both, map.bounds);
  const geo::LatLonBounds beside = Common(map.bounds, {-179.9, -17.08, -179.8, -17.05});
  EXPECT_GT(beside.west_deg, beside.east_deg);
  // The other way round: of a map east of it, one across it.
  const geo::LatLonBounds across = Common({-179.9998, -17.05, -179.9990, -16.9}, map.bounds);
  EXPECT_NEAR(across.west_deg, -179.9998, 1e-9);
  EXPECT_NEAR(across.east_deg, -179.9994, 1e-9);
  ExportRequest request;
  request.boundary = *ParseBoundary(BoxText({-179.9998, -17.08, -179.9996, -17.05}));
  EXPECT_TRUE(CheckExport(request, map).ok());
  request.boundary = *ParseBoundary(BoxText({-179.9, -17.08, -179.8, -17.05}));
  EXPECT_FALSE(CheckExport(request, map).ok());
}

TEST(RemarkOnCrs, SaysToWhatAnOlderDatumIsKnown) {
  const auto remark = RemarkOnCrs("EPSG:3003", {45.0, 9.0});  // Monte Mario
  ASSERT_TRUE(remark);
  EXPECT_EQ(remark->code, flight::RemarkCode::kExportSystemInexact);
  EXPECT_TRUE(flight::InWords(*remark).starts_with("EPSG:3003 counts from an older datum"))
      << flight::InWords(*remark);
  for (const char* crs : {"", "utm", "EPSG:3857", "EPSG:4326", "EPSG:25832", "EPSG:2056", "no system"})
    EXPECT_FALSE(RemarkOnCrs(crs, {46.95, 7.44})) << crs;
}

TEST(FindTargetCrs, KnowsHowLongAMetreIs) {
  EXPECT_EQ(FindTargetCrs(32632, {46.8, 7.1})->units_per_m_east, 1.0);
  EXPECT_NEAR(FindTargetCrs(3857, {46.8, 7.1})->units_per_m_east, 1 / std::cos(46.8 * M_PI / 180), 0.004);
  const auto feet = FindTargetCrs(2263, {40.7, -73.9});  // New York, in survey feet
  ASSERT_TRUE(feet.ok()) << feet.error().message;
  EXPECT_NEAR(feet->units_per_m_north, 3.2808, 0.001);
  EXPECT_TRUE(FindTargetCrs(32632, {46.8, 13.0}).ok());  // a little beyond the zone
  EXPECT_FALSE(FindTargetCrs(2263, {46.8, 7.1}).ok());
  EXPECT_TRUE(FindTargetCrs(3832, {-17.0, 179.9}).ok());  // across the antimeridian
  const double merc_per_m = 1 / std::cos(17.0 * M_PI / 180);
  for (const double lon_deg : {179.9995, 180.0, 180.0005})
    EXPECT_NEAR(FindTargetCrs(3857, {-17.0, lon_deg})->units_per_m_east, merc_per_m, 0.01) << lon_deg;
}

}  // namespace
}  // namespace skyquilt::storage
