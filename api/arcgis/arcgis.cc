#include "api/arcgis/arcgis.h"

#include <nlohmann/json.hpp>

#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/ogc/map_view.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

Response MapServer(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Problem(map.error(), request);
  const auto [low, high] = geo::MercFromLatLonBounds(map->revision().bounds);
  const Value reference = {{"wkid", 102100}, {"latestWkid", 3857}};
  const Value extent = {{"xmin", low.x()},
                        {"ymin", low.y()},
                        {"xmax", high.x()},
                        {"ymax", high.y()},
                        {"spatialReference", reference}};
  // Scales are of ArcGIS' 96 pixels an inch.
  constexpr double kPixelsPerMetre = 96.0 / 0.0254;
  Value levels = Value::array();
  for (const TileMatrix& matrix : MatricesOf(*map)) {
    levels.push_back({{"level", matrix.zoom},
                      {"resolution", matrix.pixel_m},
                      {"scale", matrix.pixel_m * kPixelsPerMetre}});
  }
  Value answer;
  answer["currentVersion"] = 10.91;
  answer["serviceDescription"] = map->name;
  answer["mapName"] = map->name;
  answer["description"] = "";
  answer["copyrightText"] = "";
  answer["supportsDynamicLayers"] = false;
  answer["layers"] = Value::array({{{"id", 0},
                                    {"name", map->name},
                                    {"parentLayerId", -1},
                                    {"defaultVisibility", true},
                                    {"subLayerIds", nullptr},
                                    {"minScale", 0},
                                    {"maxScale", 0}}});
  answer["tables"] = Value::array();
  answer["spatialReference"] = reference;
  answer["singleFusedMapCache"] = true;
  answer["tileInfo"] = {{"rows", map->tile_size_px()},
                        {"cols", map->tile_size_px()},
                        {"dpi", 96},
                        {"format", "MIXED"},
                        {"compressionQuality", 85},
                        {"origin", {{"x", -geo::kMercHalfWidthM}, {"y", geo::kMercHalfWidthM}}},
                        {"spatialReference", reference},
                        {"lods", levels}};
  answer["initialExtent"] = extent;
  answer["fullExtent"] = extent;
  answer["minScale"] = levels.front()["scale"];
  answer["maxScale"] = levels.back()["scale"];
  answer["units"] = "esriMeters";
  answer["supportedImageFormatTypes"] = "PNG,JPG";
  answer["capabilities"] = "Map";
  answer["exportTilesAllowed"] = false;
  std::string text = answer.dump(-1, ' ', false, Value::error_handler_t::replace);
  Response response = Text(200, std::move(text), "application/json");
  response.headers.Add("Cache-Control", "no-cache");
  return response;
}

Result<Response> ArcgisTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const TilePath path, ParseTilePath(request.Parameter("z"), request.Parameter("column"),
                                                         request.Parameter("row")));
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = path.tile;
  return AnswerTile(service, request, wanted);
}

}  // namespace

void AddArcgisRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/arcgis/rest/services/{flight}/MapServer",
             [&](const Request& r) { return MapServer(service, r); });
  router.AddQuick(Method::kGet, "/arcgis/rest/services/{flight}/MapServer/tile/{z}/{row}/{column}",
                  [&](const Request& r) { return TileResponse(ArcgisTile(service, r), r); });
}

}  // namespace skyquilt::api
