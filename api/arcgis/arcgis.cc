// A map as an ArcGIS MapServer, as far as ArcGIS clients use a tiled one: the service description, and tiles
// by level, row and column.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "api/auth/flight_access.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "api/views/map_view.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr double kArcgisVersion = 10.91;
constexpr int kServicesAtOnce = 1000;  // of the catalogue
// Scales are of ArcGIS' 96 pixels an inch.
constexpr double kPixelsPerMetre = 96.0 / 0.0254;

// "f" says how a document is wanted; JSON is all there is, and what nobody asked for otherwise.
Result<Response> AnswerArcgis(const Request& request, const Value& document) {
  const std::string format = Parameter(request, "f").value_or("json");
  const bool is_pretty = EqualsIgnoringCase(format, "pjson");
  if (!is_pretty && !format.empty() && !EqualsIgnoringCase(format, "json")) {
    return Error{ErrorCode::kInvalidArgument, "This is there as JSON: ask for f=json or f=pjson."};
  }
  return NoCache(Text(200, JsonText(document, is_pretty ? 1 : -1), "application/json"));
}

Result<Response> ArcgisServices(Service& service, const Request& request) {
  Value services = Value::array();
  std::optional<std::string> cursor;
  do {
    SKYQUILT_TRY_ASSIGN(const storage::MapPage page,
                        ListVisibleMaps(service, request, kServicesAtOnce, cursor));
    for (const storage::ShownFlight& map : page.maps)
      services.push_back({{"name", map.flight_id}, {"type", "MapServer"}});
    cursor = page.next_cursor;
  } while (cursor);
  return AnswerArcgis(
      request, {{"currentVersion", kArcgisVersion}, {"folders", Value::array()}, {"services", services}});
}

// What clients ask first: which version speaks, and whether it wants tokens of ArcGIS' own kind. It does not:
// tokens of this server come in the address or the header.
Result<Response> ArcgisInfo(const Request& request) {
  return AnswerArcgis(request, {{"currentVersion", kArcgisVersion},
                                {"fullVersion", fmt::format("{}", kArcgisVersion)},
                                {"authInfo", {{"isTokenBasedSecurity", false}}}});
}

Value Reference() { return {{"wkid", 102100}, {"latestWkid", 3857}}; }

Value ExtentOf(const MapView& map) {
  const auto [low, high] = geo::MercFromLatLonBounds(map.revision().bounds);
  return {{"xmin", low.x()},
          {"ymin", low.y()},
          {"xmax", high.x()},
          {"ymax", high.y()},
          {"spatialReference", Reference()}};
}

// Tiles of 256 pixels, whatever the stored ones: a service has one size, and programs take that for granted.
int SizeOf(const MapView& map) { return map.tile_sizes_px().front(); }

// From the whole world on, as programs count levels (GDAL takes the size of the world from level 0).
Value Levels(const MapView& map) {
  Value levels = Value::array();
  for (int zoom = 0; zoom <= MatricesOf(map, SizeOf(map)).back().zoom; ++zoom) {
    const double pixel_m = geo::PixelSizeInMercM(zoom, SizeOf(map));
    levels.push_back({{"level", zoom}, {"resolution", pixel_m}, {"scale", pixel_m * kPixelsPerMetre}});
  }
  return levels;
}

Value LayerSummary(const MapView& map) {
  return {{"id", 0},
          {"name", map.name},
          {"parentLayerId", -1},
          {"defaultVisibility", true},
          {"subLayerIds", nullptr},
          {"minScale", 0},
          {"maxScale", 0},
          {"type", "Raster Layer"}};
}

Value MapServer(const MapView& map) {
  Value answer;
  answer["currentVersion"] = kArcgisVersion;
  answer["serviceDescription"] = map.name;
  answer["mapName"] = map.name;
  answer["description"] = "";
  answer["copyrightText"] = "";
  answer["supportsDynamicLayers"] = false;
  answer["layers"] = Value::array({LayerSummary(map)});
  answer["tables"] = Value::array();
  answer["spatialReference"] = Reference();
  answer["singleFusedMapCache"] = true;
  answer["tileInfo"] = {{"rows", SizeOf(map)},
                        {"cols", SizeOf(map)},
                        {"dpi", 96},
                        {"format", "MIXED"},
                        {"compressionQuality", 85},
                        {"origin", {{"x", -geo::kMercHalfWidthM}, {"y", geo::kMercHalfWidthM}}},
                        {"spatialReference", Reference()},
                        {"lods", Levels(map)}};
  answer["initialExtent"] = ExtentOf(map);
  answer["fullExtent"] = ExtentOf(map);
  const std::vector<TileMatrix> matrices = MatricesOf(map, SizeOf(map));
  answer["minScale"] = matrices.front().pixel_m * kPixelsPerMetre;
  answer["maxScale"] = matrices.back().pixel_m * kPixelsPerMetre;
  answer["units"] = "esriMeters";
  answer["supportedImageFormatTypes"] = "PNG,JPG";
  answer["capabilities"] = "Map,TilesOnly";  // without the second word programs ask for pictures (export)
  answer["exportTilesAllowed"] = false;
  return answer;
}

Value ArcgisLayer(const MapView& map) {
  Value answer = LayerSummary(map);
  answer["currentVersion"] = kArcgisVersion;
  answer["description"] = "";
  answer["copyrightText"] = "";
  answer["parentLayer"] = nullptr;
  answer["subLayers"] = Value::array();
  answer["extent"] = ExtentOf(map);
  answer["geometryType"] = nullptr;
  answer["fields"] = nullptr;
  answer["capabilities"] = "Map";
  return answer;
}

Value ArcgisLayers(const MapView& map) {
  return {{"layers", Value::array({ArcgisLayer(map)})}, {"tables", Value::array()}};
}

// A picture of the ground has no classes to explain.
Value ArcgisLegend(const MapView& map) {
  Value layer;
  layer["layerId"] = 0;
  layer["layerName"] = map.name;
  layer["layerType"] = "Raster Layer";
  layer["minScale"] = 0;
  layer["maxScale"] = 0;
  layer["legend"] = Value::array();
  Value answer;
  answer["layers"] = Value::array({layer});
  return answer;
}

// Identify, find, export and what else a map service may have.
Result<Response> ArcgisUnknown(const Request& request) {
  return Error{ErrorCode::kNotFound,
               fmt::format("A map service of this server has no \"{}\": it has tiles, 0, layers and legend. "
                           "What is at a place is told by /api/v1/flights/{}/point?lon=...&lat=...",
                           request.Parameter("operation"), request.Parameter("flight"))};
}

Result<Response> ArcgisTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const TilePath path, ParseTilePath(request.Parameter("z"), request.Parameter("column"),
                                                         request.Parameter("row")));
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = path.tile;
  wanted.side_px = kUsualTilePx;
  wanted.is_of_world = true;
  return AnswerTile(service, request, wanted);
}

}  // namespace

void AddArcgisRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/arcgis/rest/info", [](const Request& r) { return ArcgisInfo(r); });
  router.Add(Method::kGet, "/arcgis/rest/services", On(service, ArcgisServices));
  const auto add = [&](const char* rest, Value (*describe)(const MapView&)) {
    router.Add(Method::kGet, std::string("/arcgis/rest/services/{flight}/MapServer") + rest,
               [&service, describe](const Request& request) -> Result<Response> {
                 SKYQUILT_TRY_ASSIGN(const MapView map,
                                     FindMap(service, request, request.Parameter("flight")));
                 return AnswerArcgis(request, describe(map));
               });
  };
  add("", MapServer);
  add("/0", ArcgisLayer);
  add("/layers", ArcgisLayers);
  add("/legend", ArcgisLegend);
  router.AddQuick(Method::kGet, "/arcgis/rest/services/{flight}/MapServer/{operation}",
                  [](const Request& r) { return ArcgisUnknown(r); });
  router.AddQuick(Method::kGet, "/arcgis/rest/services/{flight}/MapServer/tile/{z}/{row}/{column}",
                  On(service, ArcgisTile));
}

}  // namespace skyquilt::api
