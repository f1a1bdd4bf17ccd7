// Tiles of a map in WorldCRS84Quad and in UTM's grid: the grids as OGC registers them, the limits of a map in
// them, and that every pixel shows the place at which it lies.
#include <nlohmann/json.hpp>

#include "api/grids/grid_tiles.h"
#include "api/grids/map_grid.h"
#include "tests/api/maps/textured_map.h"
#include "tests/storage/rasters/band_file.h"
#include "tests/support/value_of.h"

namespace skyquilt::api {
namespace {

using nlohmann::json;

constexpr geo::LatLon kValais{.lat_deg = 47.1, .lon_deg = 8.3}, kTasmania{.lat_deg = -42.9, .lon_deg = 147.3};

// By the register: opengeospatial/2D-Tile-Matrix-Set, registry/json/UTM31WGS84Quad.json and so on.
TEST(MapGrid, UtmIsAsRegistered) {
  const MapGrid grid = MapGrid::Utm(31);
  EXPECT_EQ(grid.name(), "UTM31WGS84Quad");
  EXPECT_EQ(grid.uri(), "http://www.opengis.net/def/tilematrixset/OGC/1.0/UTM31WGS84Quad");
  EXPECT_EQ(grid.Crs()->uri(), "http://www.opengis.net/def/crs/EPSG/0/32631");
  EXPECT_EQ(std::pair(grid.first_level(), grid.last_level()), std::pair(1, 24));
  EXPECT_NEAR(grid.UpperLeft().x(), -9501965.72931276, 1e-8);
  EXPECT_NEAR(grid.UpperLeft().y(), 20003931.4586255, 1e-7);
  struct Registered {
    int level;
    double scale_denominator, cell_size;
    std::int64_t columns, rows;
  };
  for (const Registered& want : {Registered{1, 279072704.500914, 78140.3572602559, 1, 2},
                                 Registered{2, 139536352.250457, 39070.178630128, 2, 4},
                                 Registered{17, 4258.31153108084, 1.19232722870264, 65536, 131072},
                                 Registered{24, 33.2680588365691, 0.00931505647423934, 8388608, 16777216}}) {
    EXPECT_NEAR(grid.ScaleDenominator(want.level) / want.scale_denominator, 1.0, 1e-14) << want.level;
    EXPECT_NEAR(grid.CellSize(want.level) / want.cell_size, 1.0, 1e-14) << want.level;
    EXPECT_EQ(grid.Columns(want.level), want.columns);
    EXPECT_EQ(grid.Rows(want.level), want.rows);
  }
  EXPECT_EQ(MapGrid::Utm(1).name(), "UTM01WGS84Quad");
  // Its tiles are as high as a quarter of the meridian is long: the radius of a sphere with the same
  // meridian.
  constexpr double n = geo::kWgs84Flattening / (2.0 - geo::kWgs84Flattening);
  const double radius =
      geo::kWgs84SemiMajorM / (1.0 + n) * (1.0 + n * n / 4.0 + n * n * n * n / 64.0 + std::pow(n, 6) / 256.0);
  EXPECT_NEAR(grid.CellSize(1) * 256.0, radius * geo::kPi, 1e-5);
}

TEST(MapGrid, DegreesAreAsRegistered) {
  const MapGrid grid = MapGrid::WorldCrs84();
  EXPECT_EQ(grid.name(), "WorldCRS84Quad");
  EXPECT_TRUE(grid.Crs()->is_crs84());
  EXPECT_EQ(std::pair(grid.first_level(), grid.last_level()), std::pair(0, 23));
  EXPECT_EQ(grid.UpperLeft(), Eigen::Vector2d(-180.0, 90.0));
  EXPECT_EQ(grid.CellSize(0), 0.703125);
  EXPECT_NEAR(grid.ScaleDenominator(0) / 279541132.014358, 1.0, 1e-14);
  EXPECT_NEAR(grid.ScaleDenominator(23) / 33.3238997476528, 1.0, 1e-14);
  EXPECT_EQ(std::pair(grid.Columns(0), grid.Rows(0)), (std::pair<std::int64_t, std::int64_t>(2, 1)));
  EXPECT_EQ(std::pair(grid.Columns(23), grid.Rows(23)),
            (std::pair<std::int64_t, std::int64_t>(16777216, 8388608)));
}

TEST(MapGrid, IsFoundByItsNameAlone) {
  EXPECT_EQ(MapGrid::Named("WorldCRS84Quad")->name(), "WorldCRS84Quad");
  EXPECT_EQ(MapGrid::Named("UTM60WGS84Quad")->name(), "UTM60WGS84Quad");
  for (const char* name : {"", "UTM00WGS84Quad", "UTM61WGS84Quad", "UTM1WGS84Quad", "UTM32WGS84",
                           "WebMercatorQuad", "worldcrs84quad"}) {
    EXPECT_FALSE(MapGrid::Named(name)) << name;
  }
}

TEST(MapGrid, AMapIsInTheGridOfItsZone) {
  const auto names = [](double lat, double lon) {
    storage::Revision revision;
    revision.bounds = {lon - 0.01, lat - 0.01, lon + 0.01, lat + 0.01};
    std::string all;
    for (const MapGrid& grid : GridsOf(revision)) all += grid.name() + " ";
    return all;
  };
  EXPECT_EQ(names(47.1, 8.3), "WorldCRS84Quad UTM32WGS84Quad ");
  EXPECT_EQ(names(-42.9, 147.3), "WorldCRS84Quad UTM55WGS84Quad ");
  EXPECT_EQ(names(60.4, 5.3), "WorldCRS84Quad UTM32WGS84Quad ");  // Bergen, by Norway's wider zone
  EXPECT_EQ(names(-17.0, 180.0), "WorldCRS84Quad UTM01WGS84Quad ");
  EXPECT_EQ(names(86.0, 10.0), "WorldCRS84Quad ");  // beyond UTM
}

class GridTiles : public testing::TestWithParam<std::tuple<geo::LatLon, int>> {
 protected:
  GridTiles()
      : map_(sample_, std::get<0>(GetParam()), std::get<1>(GetParam())),
        at_("/ogc/collections/" + map_.flight() + "/map/tiles") {}

  // The one of a map's grids that begins so.
  std::string Grid(const std::string& begin) {
    storage::Revision revision;
    revision.bounds = map_.bounds();
    for (const MapGrid& grid : GridsOf(revision)) {
      if (grid.name().starts_with(begin)) return grid.name();
    }
    return "";
  }
  static geo::LatLon PositionOf(const MapGrid& grid, double x, double y) {
    if (grid.is_in_degrees()) return {.lat_deg = y, .lon_deg = x};
    return LatLonOfUtm(std::stoi(grid.name().substr(3, 2)), x, y);
  }

  // Every tile within a map's limits, at every level.
  void CompareAll(const std::string& name) {
    const MapGrid grid = *MapGrid::Named(name);
    const json tileset = sample_.Json(at_ + "/" + name);
    int shown = 0;
    for (const json& limits : tileset["tileMatrixSetLimits"]) {
      const int level = std::stoi(limits["tileMatrix"].get<std::string>());
      for (int row = limits["minTileRow"]; row <= limits["maxTileRow"]; ++row) {
        for (int column = limits["minTileCol"]; column <= limits["maxTileCol"]; ++column) {
          const std::string tile =
              "/" + std::to_string(level) + "/" + std::to_string(row) + "/" + std::to_string(column) + ".png";
          if (sample_.Get(at_ + "/" + name + tile).status == 204) continue;
          const image::RgbaImage picture = sample_.Picture(at_ + "/" + name + tile);
          ASSERT_EQ(std::pair(picture.width_px, picture.height_px), std::pair(256, 256));
          const geo::Bounds2 box = grid.BoundsOf(level, column, row);
          shown += map_.Compare(picture, [&](double x, double y) {
            return PositionOf(grid, box.min.x() + x * grid.CellSize(level),
                              box.max.y() - y * grid.CellSize(level));
          });
        }
      }
      // What lies beside them is no tile of the map.
      EXPECT_EQ(sample_
                    .Get(at_ + "/" + name + "/" + std::to_string(level) + "/" +
                         std::to_string(limits["maxTileRow"].get<int>() + 1) + "/" +
                         std::to_string(limits["minTileCol"].get<int>()))
                    .status,
                404);
    }
    // All of the map, at its finest level alone.
    EXPECT_GT(shown, 900 * 900);
  }

  SampleService sample_;
  TexturedMap map_;
  std::string at_;
};

TEST_P(GridTiles, OfDegreesShowEveryPlaceWhereItLies) { CompareAll("WorldCRS84Quad"); }
TEST_P(GridTiles, OfUtmShowEveryPlaceWhereItLies) { CompareAll(Grid("UTM")); }

TEST_P(GridTiles, LoseNothingOfTheFinestZoom) {
  storage::Revision revision;
  revision.bounds = map_.bounds();
  revision.min_zoom = TexturedMap::kZoom - 1;
  revision.max_zoom = TexturedMap::kZoom;
  const int side_px = std::get<1>(GetParam());
  for (const MapGrid& grid : GridsOf(revision)) {
    const std::vector<GridMatrix> matrices = MatricesOf(grid, revision, side_px);
    ASSERT_GE(matrices.size(), 2u);
    // How wide and high the finest cells are on the ground, next to the map's own pixels.
    const double lat = revision.bounds.Middle().lat_deg;
    const double metres = grid.CellSize(matrices.back().level) * (grid.is_in_degrees() ? 111200.0 : 1.0);
    const double own =
        geo::PixelSizeInMercM(TexturedMap::kZoom, side_px) * geo::GroundMetresPerMercMetre(lat);
    EXPECT_LE(metres, own * 1.01) << grid.name();
    EXPECT_GT(metres, own / 2.02) << grid.name();
  }
}

INSTANTIATE_TEST_SUITE_P(NorthAndSouth, GridTiles,
                         testing::Values(std::tuple(kValais, 256), std::tuple(kTasmania, 256),
                                         std::tuple(kValais, 512)));

class GridAddresses : public testing::Test {
 protected:
  std::string Tile(const std::string& grid, const std::string& ending) {
    const MapGrid known = *MapGrid::Named(grid);
    const Result<MapCrs> crs = known.Crs();
    const auto place = crs->PlaceOf(map_.bounds().Middle());
    const double side = known.CellSize(kLevel) * 256;
    const auto column = static_cast<std::int64_t>((place->x() - known.UpperLeft().x()) / side);
    const auto row = static_cast<std::int64_t>((known.UpperLeft().y() - place->y()) / side);
    return grid + "/" + std::to_string(kLevel) + "/" + std::to_string(row) + "/" + std::to_string(column) +
           ending;
  }
  static constexpr int kLevel = 18;
  SampleService sample_;
  TexturedMap map_{sample_, kValais};
  std::string ogc_ = "/ogc/collections/" + map_.flight() + "/map/tiles/";
  std::string wmts_ = "/wmts/" + map_.flight() + "/map/default/";
};

TEST_F(GridAddresses, WmtsHasTheSameTiles) {
  for (const char* grid : {"WorldCRS84Quad", "UTM32WGS84Quad"}) {
    const Response ogc = sample_.Get(ogc_ + Tile(grid, ".png")),
                   wmts = sample_.Get(wmts_ + Tile(grid, ".png"));
    EXPECT_EQ(ogc.status, 200) << ogc.body;
    EXPECT_EQ(wmts.status, 200) << wmts.body;
    EXPECT_EQ(ogc.body, wmts.body);
    const std::string path = Tile(grid, "");
    const std::size_t row = path.rfind('/', path.rfind('/') - 1);
    const Response kvp = sample_.Get(
        "/wmts/" + map_.flight() +
        "?service=WMTS&request=GetTile&version=1.0.0&layer=map&format=image/png&tilematrixset=" + grid +
        "&tilematrix=" + std::to_string(kLevel) + "&tilerow=" +
        path.substr(row + 1, path.rfind('/') - row - 1) + "&tilecol=" + path.substr(path.rfind('/') + 1));
    EXPECT_EQ(kvp.body, ogc.body) << kvp.status;
  }
}

TEST_F(GridAddresses, TilesAreKeptAndTagged) {
  const std::string path = ogc_ + Tile("UTM32WGS84Quad", ".png");
  const Response first = sample_.Get(path);
  const auto kept = sample_.service().made_tiles.kept().tiles;
  EXPECT_GE(kept, 1u);
  EXPECT_EQ(sample_.Get(path).body, first.body);
  EXPECT_EQ(sample_.service().made_tiles.kept().tiles, kept);
  EXPECT_EQ(sample_.Get(path, {{"If-None-Match", std::string(first.headers.Find("ETag"))}}).status, 304);
  EXPECT_NE(sample_.Get(path + "?rev=" + std::to_string(map_.revision()))
                .headers.Find("Cache-Control")
                .find("immutable"),
            std::string_view::npos);
  // Another grid's tile of the same level has other bytes.
  EXPECT_NE(sample_.Get(ogc_ + Tile("WorldCRS84Quad", ".png")).body, first.body);
}

TEST_F(GridAddresses, TilesComeInEveryFormatAndAsStoredUnlessAsked) {
  const std::string path = ogc_ + Tile("UTM32WGS84Quad", "");
  EXPECT_EQ(sample_.Get(path).headers.Find("Content-Type"), "image/jpeg");  // opaque throughout
  EXPECT_EQ(sample_.Get(path + "?f=webp").headers.Find("Content-Type"), "image/webp");
  Headers png{{"Accept", "image/png"}};
  EXPECT_EQ(sample_.Get(path, png).headers.Find("Content-Type"), "image/png");
  EXPECT_EQ(sample_.Get(path + "?f=tiff").status, 406);
  EXPECT_EQ(sample_.Get(path + ".gif").status, 400);
  EXPECT_EQ(sample_.Get(path + "@2x.png").status, 400);
}

TEST_F(GridAddresses, WhatIsNoTileIsRefused) {
  for (const char* tile :
       {"UTM32WGS84Quad/0/0/0", "UTM32WGS84Quad/25/0/0", "UTM32WGS84Quad/1/2/0", "UTM32WGS84Quad/1/0/1",
        "WorldCRS84Quad/24/0/0", "WorldCRS84Quad/0/1/0", "WorldCRS84Quad/0/0/2", "WorldCRS84Quad/a/0/0",
        "WorldCRS84Quad/1/-1/0", "UTM32WGS84Quad/9999999999/0/0"}) {
    EXPECT_EQ(sample_.Get(ogc_ + tile).status, 400) << tile;
    const Response wmts = sample_.Get(wmts_ + tile);
    EXPECT_EQ(wmts.status, 400) << tile;
    EXPECT_NE(wmts.body.find("TileOutOfRange"), std::string::npos) << wmts.body;
  }
  // Tiles of the grid that are none of the map.
  for (const char* tile :
       {"UTM32WGS84Quad/1/0/0", "UTM32WGS84Quad/18/0/0", "WorldCRS84Quad/0/0/1", "WorldCRS84Quad/18/0/0"}) {
    EXPECT_EQ(sample_.Get(ogc_ + tile).status, 404) << tile;
    EXPECT_EQ(sample_.Get(wmts_ + tile).status, 404) << tile;
  }
  // The zone beside the map's, and what is no set.
  for (const char* set : {"UTM33WGS84Quad", "UTM99WGS84Quad", "WebMercatorQuad512"}) {
    const Response response = sample_.Get(ogc_ + set);
    EXPECT_EQ(response.status, 404) << set;
    EXPECT_NE(response.body.find("UTM32WGS84Quad"), std::string::npos) << response.body;
  }
}

TEST_F(GridAddresses, DocumentsNameAndDefineThem) {
  const json list = json::parse(sample_.Get("/ogc/tileMatrixSets").body)["tileMatrixSets"];
  ASSERT_EQ(list.size(), 3u + 1u + 60u);
  for (const json& entry : list) {
    const std::string href = entry["links"][0]["href"];
    const Response response = sample_.Get(href.substr(href.find("/ogc")));
    ASSERT_EQ(response.status, 200) << href;
    const json set = json::parse(response.body);
    EXPECT_EQ(set["id"], entry["id"]);
    if (entry.contains("uri")) {
      EXPECT_EQ(set["uri"], entry["uri"]);
    }
    EXPECT_EQ(set["tileMatrices"].size(), set["tileMatrix"].size());
    for (const json& matrix : set["tileMatrices"]) {
      EXPECT_EQ(matrix["cornerOfOrigin"], "topLeft");
      EXPECT_GT(matrix["matrixWidth"].get<std::int64_t>(), 0);
    }
  }
  const json utm = json::parse(sample_.Get("/ogc/tileMatrixSets/UTM32WGS84Quad").body);
  EXPECT_EQ(utm["crs"], "http://www.opengis.net/def/crs/EPSG/0/32632");
  EXPECT_EQ(utm["orderedAxes"], json({"E", "N"}));
  EXPECT_EQ(utm["tileMatrices"][0]["id"], "1");
  EXPECT_EQ(utm["tileMatrices"][23]["id"], "24");
  const json degrees = json::parse(sample_.Get("/ogc/tileMatrixSets/WorldCRS84Quad").body);
  EXPECT_EQ(degrees["crs"], "http://www.opengis.net/def/crs/OGC/1.3/CRS84");
  EXPECT_EQ(degrees["orderedAxes"], json({"Lon", "Lat"}));
  EXPECT_EQ(degrees["tileMatrices"][0]["pointOfOrigin"], json({-180.0, 90.0}));
  EXPECT_EQ(sample_.Get("/ogc/tileMatrixSets/UTM61WGS84Quad").status, 404);

  const json tilesets = json::parse(sample_.Get(ogc_.substr(0, ogc_.size() - 1)).body)["tilesets"];
  ASSERT_EQ(tilesets.size(), 3u);
  EXPECT_EQ(tilesets[0]["tileMatrixSetURI"],
            "http://www.opengis.net/def/tilematrixset/OGC/1.0/WebMercatorQuad");
  EXPECT_EQ(tilesets[2]["tileMatrixSetURI"], utm["uri"]);
  EXPECT_EQ(tilesets[2]["crs"], utm["crs"]);
  const std::string wmts = sample_.Get("/wmts/" + map_.flight()).body;
  for (const char* part :
       {"<TileMatrixSet>WorldCRS84Quad</TileMatrixSet>", "<TileMatrixSet>UTM32WGS84Quad</TileMatrixSet>",
        "<ows:SupportedCRS>urn:ogc:def:crs:OGC:1.3:CRS84</ows:SupportedCRS>",
        "<ows:SupportedCRS>urn:ogc:def:crs:EPSG::32632</ows:SupportedCRS>",
        "<TopLeftCorner>-180 90</TopLeftCorner>",
        "<TopLeftCorner>-9501965.72931276 20003931.4586255</TopLeftCorner>"}) {
    EXPECT_NE(wmts.find(part), std::string::npos) << part;
  }
  EXPECT_LT(wmts.find("<TileMatrixSet>WebMercatorQuad<"), wmts.find("<TileMatrixSet>WorldCRS84Quad<"));
  EXPECT_NE(sample_.Get("/wmts").body.find("<TileMatrixSet>UTM32WGS84Quad<"), std::string::npos);
}

TEST_F(GridAddresses, IndicesAndPlacesAreThoseOfTheGridToo) {
  const std::string path = Tile("UTM32WGS84Quad", ".png");
  const Response coloured = sample_.Get("/wmts/" + map_.flight() + "/map/vari/" + path);
  EXPECT_EQ(coloured.status, 200) << coloured.body;
  EXPECT_NE(coloured.body, sample_.Get(wmts_ + path).body);
  EXPECT_EQ(sample_.Get("/wmts/" + map_.flight() + "/map/nonsense/" + path).status, 400);
  // The middle of a pixel is where the tests of the tiles have it.
  const MapGrid grid = MapGrid::Utm(32);
  const auto position = test::ValueOf(PositionInGrid(grid, 18, 70000, 60000, {10.0, 20.0}));
  const geo::Bounds2 box = grid.BoundsOf(18, 70000, 60000);
  const geo::LatLon want =
      LatLonOfUtm(32, box.min.x() + 10.5 * grid.CellSize(18), box.max.y() - 20.5 * grid.CellSize(18));
  EXPECT_NEAR(position.lat_deg, want.lat_deg, 1e-8);
  EXPECT_NEAR(position.lon_deg, want.lon_deg, 1e-8);
  EXPECT_FALSE(PositionInGrid(grid, 25, 0, 0, {0.0, 0.0}));
}

TEST_F(GridAddresses, BandsOfARasterLieWhereTheMapDoes) {
  // Near infrared grows from west to east over the whole map, red is a tenth.
  const geo::Bounds2& bounds = map_.bounds_in_merc();
  constexpr int kSide = 1024;
  test::WriteBandFile(
      sample_.dir().Revision(map_.flight(), map_.revision()) / "bands.tif",
      {bounds.min.x(),
       bounds.max.y(),
       bounds.Width() / kSide,
       kSide,
       kSide,
       {"green", "red", "rededge", "nir"},
       [](int band, int column, int) { return band == 3 ? static_cast<float>(column) / kSide : 0.1f; }});
  const std::string path = Tile("UTM32WGS84Quad", ".png");
  const Response response = sample_.Get("/wmts/" + map_.flight() + "/map/ndvi/" + path);
  ASSERT_EQ(response.status, 200) << response.body;
  const auto picture = test::ValueOf(image::DecodePicture(response.body));
  const IndexLook look = **LookOfStyle("ndvi");
  const std::size_t slash = path.rfind('/'), before = path.rfind('/', slash - 1);
  const geo::Bounds2 box = MapGrid::Utm(32).BoundsOf(kLevel, std::stoll(path.substr(slash + 1)),
                                                     std::stoll(path.substr(before + 1)));
  int compared = 0;
  for (int y = 5; y < 256; y += 10) {
    for (int x = 5; x < 256; x += 10) {
      const double cell = MapGrid::Utm(32).CellSize(kLevel);
      const Eigen::Vector2d merc = geo::MercFromLatLon(
          LatLonOfUtm(32, box.min.x() + (x + 0.5) * cell, box.max.y() - (y + 0.5) * cell));
      const double nir = (merc.x() - bounds.min.x()) / bounds.Width();
      const double value = (nir - 0.1) / (nir + 0.1);
      const auto& want =
          look.ramp.At(indices::ColourRamp::LevelOf(static_cast<float>(value), look.least, look.most));
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(picture.Pixel(x, y)[c], want[c], 6) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 600);
}

}  // namespace
}  // namespace skyquilt::api
