#include "api/ogc/matrix_sets.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "api/http/responses.h"
#include "api/ogc/ogc_format.h"
#include "api/tiles/recode_tile.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

using SetJson = nlohmann::ordered_json;

constexpr const char* kMercatorSet = "WebMercatorQuad";
constexpr const char* kMercatorSetUri = "http://www.opengis.net/def/tilematrixset/OGC/1.0/WebMercatorQuad";
constexpr const char* kScaleSets = "http://www.opengis.net/def/wkss/OGC/1.0/";
constexpr int kFinestZoom = 24;

SetJson SetLink(const std::string& href, const std::string& rel, const char* title) {
  return {{"href", href}, {"rel", rel}, {"type", "application/json"}, {"title", title}};
}

// "WebMercatorQuad" has tiles of 256 pixels; a number behind it is another side.
std::optional<int> MercatorSideOf(std::string_view set) {
  const std::string_view name = kMercatorSet;
  if (!set.starts_with(name)) return std::nullopt;
  if (set == name) return kUsualTilePx;
  for (const int side_px : {512, 1024, 2048, 4096}) {
    if (set.substr(name.size()) == std::to_string(side_px)) return side_px;
  }
  return std::nullopt;
}

// One level of a set, whatever the set.
struct SetMatrix {
  std::string id;
  double scale_denominator = 0.0;
  double cell_size = 0.0;
  std::array<double, 2> upper_left = {};
  int side_px = 256;
  std::int64_t columns = 0, rows = 0;
};

// The matrices in the words of the standard, and in those of its first version, which programs still go by
// (GDAL 3.6, and QGIS with it).
void AddMatrices(const std::vector<SetMatrix>& matrices, SetJson& set) {
  SetJson newer = SetJson::array(), older = SetJson::array();
  for (const SetMatrix& matrix : matrices) {
    newer.push_back({{"id", matrix.id},
                     {"scaleDenominator", matrix.scale_denominator},
                     {"cellSize", matrix.cell_size},
                     {"cornerOfOrigin", "topLeft"},
                     {"pointOfOrigin", matrix.upper_left},
                     {"tileWidth", matrix.side_px},
                     {"tileHeight", matrix.side_px},
                     {"matrixWidth", matrix.columns},
                     {"matrixHeight", matrix.rows}});
    older.push_back({{"type", "TileMatrixType"},
                     {"identifier", matrix.id},
                     {"scaleDenominator", matrix.scale_denominator},
                     {"topLeftCorner", matrix.upper_left},
                     {"tileWidth", matrix.side_px},
                     {"tileHeight", matrix.side_px},
                     {"matrixWidth", matrix.columns},
                     {"matrixHeight", matrix.rows}});
  }
  set["tileMatrices"] = newer;
  set["type"] = "TileMatrixSetType";
  set["identifier"] = set["id"];
  set["supportedCRS"] = set["crs"];
  set["tileMatrix"] = older;
}

SetJson MercatorSet(const std::string& id, int side_px) {
  SetJson set;
  set["id"] = id;
  set["title"] = "Google Maps Compatible for the World";
  if (side_px == kUsualTilePx) {
    set["uri"] = kMercatorSetUri;
    set["wellKnownScaleSet"] = std::string(kScaleSets) + "GoogleMapsCompatible";
  }
  set["crs"] = kMercatorUri;
  set["orderedAxes"] = {"E", "N"};
  std::vector<SetMatrix> matrices;
  for (int zoom = 0; zoom <= kFinestZoom; ++zoom) {
    const double cell_m = geo::PixelSizeInMercM(zoom, side_px);
    matrices.push_back({std::to_string(zoom),
                        cell_m / kOgcPixelM,
                        cell_m,
                        {-geo::kMercHalfWidthM, geo::kMercHalfWidthM},
                        side_px,
                        std::int64_t{1} << zoom,
                        std::int64_t{1} << zoom});
  }
  AddMatrices(matrices, set);
  return set;
}

SetJson GridSet(const MapGrid& grid, const MapCrs& crs) {
  SetJson set;
  set["id"] = grid.name();
  set["title"] = grid.title();
  set["uri"] = grid.uri();
  if (*grid.scale_set() != '\0') set["wellKnownScaleSet"] = std::string(kScaleSets) + grid.scale_set();
  set["crs"] = crs.uri();
  set["orderedAxes"] = grid.is_in_degrees() ? SetJson{"Lon", "Lat"} : SetJson{"E", "N"};
  std::vector<SetMatrix> matrices;
  const Eigen::Vector2d corner = grid.UpperLeft();
  for (int level = grid.first_level(); level <= grid.last_level(); ++level) {
    matrices.push_back({std::to_string(level),
                        grid.ScaleDenominator(level),
                        grid.CellSize(level),
                        {corner.x(), corner.y()},
                        MapGrid::kTilePx,
                        grid.Columns(level),
                        grid.Rows(level)});
  }
  AddMatrices(matrices, set);
  return set;
}

SetJson SummaryOf(const MapView& map, const MapSet& set) {
  const std::string at = fmt::format("/ogc/collections/{}/map/tiles/{}", map.id, set.name());
  SetJson tileset;
  tileset["title"] = map.name;
  tileset["dataType"] = "map";
  const Result<MapCrs> crs = set.grid ? set.grid->Crs() : MapCrs::Mercator();
  tileset["crs"] = crs ? crs->uri() : kMercatorUri;
  if (set.grid) {
    tileset["tileMatrixSetURI"] = set.grid->uri();
  } else if (set.side_px == kUsualTilePx) {
    tileset["tileMatrixSetURI"] = kMercatorSetUri;
  }
  SetJson links = SetJson::array();
  links.push_back(SetLink(map.Link(at), "self", "This tileset"));
  links.push_back(SetLink(map.Link("/ogc/tileMatrixSets/" + set.name()), kOgcRel + "tiling-scheme",
                          "Its tile matrix set"));
  for (const auto& [type, extension] : {std::pair{"image/png", "png"}, std::pair{"image/jpeg", "jpg"}}) {
    SetJson item = SetLink(map.Link(at + "/{tileMatrix}/{tileRow}/{tileCol}." + extension), "item", "Tiles");
    item["type"] = type;
    item["templated"] = true;
    links.push_back(item);
  }
  tileset["links"] = links;
  return tileset;
}

SetJson LimitsOf(const MapView& map, const MapSet& set) {
  SetJson limits = SetJson::array();
  const auto add = [&](int level, auto min_row, auto max_row, auto min_column, auto max_column) {
    limits.push_back({{"tileMatrix", std::to_string(level)},
                      {"minTileRow", min_row},
                      {"maxTileRow", max_row},
                      {"minTileCol", min_column},
                      {"maxTileCol", max_column}});
  };
  if (!set.grid) {
    for (const TileMatrix& matrix : MatricesOf(map, set.side_px))
      add(matrix.zoom, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
    return limits;
  }
  for (const GridMatrix& matrix : MatricesOf(*set.grid, map.revision(), map.tile_size_px()))
    add(matrix.level, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
  return limits;
}

}  // namespace

Response MatrixSetList(const Request& request) {
  SetJson sets = SetJson::array();
  const auto add = [&](const std::string& id, const std::string& uri) {
    SetJson set = {{"id", id}};
    if (!uri.empty()) set["uri"] = uri;
    set["links"] = SetJson::array(
        {OgcLink(request, "/ogc/tileMatrixSets/" + id, "self", "application/json", "Definition")});
    sets.push_back(set);
  };
  add(kMercatorSet, kMercatorSetUri);
  for (const int side_px : {512, 1024}) add(MatrixSetName(side_px), "");
  std::vector<MapGrid> grids = {MapGrid::WorldCrs84()};
  for (int zone = 1; zone <= MapGrid::kZones; ++zone) grids.push_back(MapGrid::Utm(zone));
  for (const MapGrid& grid : grids) add(grid.name(), grid.uri());
  return NoCacheJson({{"tileMatrixSets", sets}});
}

Result<Response> MatrixSetDocument(const Request& request) {
  const std::string& id = request.Parameter("set");
  if (const std::optional<int> side_px = MercatorSideOf(id)) return NoCacheJson(MercatorSet(id, *side_px));
  const std::optional<MapGrid> grid = MapGrid::Named(id);
  if (!grid) return Error{ErrorCode::kNotFound, "There is no such tile matrix set."};
  SKYQUILT_TRY_ASSIGN(const MapCrs crs, grid->Crs());
  return NoCacheJson(GridSet(*grid, crs));
}

Response TilesetList(const MapView& map) {
  SetJson links =
      SetJson::array({SetLink(map.Link("/ogc/collections/" + map.id + "/map/tiles"), "self", "This list")});
  SetJson tilesets = SetJson::array();
  for (const MapSet& set : map.sets()) tilesets.push_back(SummaryOf(map, set));
  return NoCacheJson({{"links", links}, {"tilesets", tilesets}});
}

Response TilesetDocument(const MapView& map, const MapSet& set) {
  SetJson tileset = SummaryOf(map, set);
  const SetJson limits = LimitsOf(map, set);
  tileset["tileMatrixSetLimits"] = limits;
  const auto& [west, south, east, north] = map.revision().bounds;
  tileset["boundingBox"] = {{"lowerLeft", {west, south}}, {"upperRight", {east, north}}, {"crs", kCrs84Uri}};
  tileset["centerPoint"] = {{"coordinates", {(west + east) / 2, (south + north) / 2}}, {"crs", kCrs84Uri}};
  if (!limits.empty()) tileset["centerPoint"]["tileMatrix"] = limits.back()["tileMatrix"];
  return NoCacheJson(tileset);
}

}  // namespace skyquilt::api
