#include "api/ogc/ogc.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <span>

#include "api/auth/flight_access.h"
#include "api/http/links.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/ogc/features.h"
#include "api/ogc/map_view.h"
#include "api/ogc/ogc_format.h"
#include "api/tiles/cut_tile.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

constexpr const char* kMercator = "http://www.opengis.net/def/crs/EPSG/0/3857";
constexpr const char* kCrs84 = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";

Response Document(const Value& value) {
  Response response =
      Text(200, value.dump(-1, ' ', false, Value::error_handler_t::replace), "application/json");
  response.headers.Add("Cache-Control", "no-cache");
  return response;
}

Value Link(const std::string& href, const std::string& rel, const char* type, const char* title) {
  return {{"href", href}, {"rel", rel}, {"type", type}, {"title", title}};
}

// A map whose answers need no tileset opened: for links alone.
MapView Anywhere(const Request& request) {
  MapView view;
  view.base_url = request.base_url;
  view.token = TokenInQuery(request);
  return view;
}

Response Landing(const Request& request) {
  const MapView at = Anywhere(request);
  Value links = Value::array();
  links.push_back(Link(at.Link("/ogc"), "self", "application/json", "This document"));
  links.push_back(Link(at.Link("/openapi.json"), "service-desc",
                       "application/vnd.oai.openapi+json;version=3.1", "The API"));
  links.push_back(Link(at.Link("/docs"), "service-doc", "text/html", "The API, to read"));
  links.push_back(
      Link(at.Link("/ogc/conformance"), "conformance", "application/json", "Conformance classes"));
  links.push_back(
      Link(at.Link("/ogc/conformance"), kOgcRel + "conformance", "application/json", "Conformance classes"));
  links.push_back(Link(at.Link("/ogc/collections"), "data", "application/json", "Maps"));
  links.push_back(Link(at.Link("/ogc/collections"), kOgcRel + "data", "application/json", "Maps"));
  links.push_back(Link(at.Link("/ogc/tileMatrixSets"), kOgcRel + "tiling-schemes", "application/json",
                       "Tile matrix sets"));
  return Document({{"title", "Skyquilt"}, {"description", "Maps made of aerial photos"}, {"links", links}});
}

Response Conformance(const Request&) {
  Value classes = Value::array();
  for (const char* name : {"ogcapi-common-1/1.0/conf/core", "ogcapi-common-1/1.0/conf/json",
                           "ogcapi-common-2/1.0/conf/collections", "ogcapi-tiles-1/1.0/conf/core",
                           "ogcapi-tiles-1/1.0/conf/tileset", "ogcapi-tiles-1/1.0/conf/tilesets-list",
                           "ogcapi-tiles-1/1.0/conf/geodata-tilesets", "ogcapi-tiles-1/1.0/conf/png",
                           "ogcapi-tiles-1/1.0/conf/jpeg", "tms/2.0/conf/tilematrixset",
                           "ogcapi-features-1/1.0/conf/core", "ogcapi-features-1/1.0/conf/geojson"}) {
    classes.push_back(std::string("http://www.opengis.net/spec/") + name);
  }
  return Document({{"conformsTo", classes}});
}

// Imported maps have no photos.
std::span<const PhotoFeatures> FeaturesOf(const storage::ShownFlight& map) {
  if (map.revision.photos_total == 0) return {};
  return kPhotoFeatures;
}

Value Collection(const Request& request, const storage::ShownFlight& map) {
  const auto link = [&](const std::string& path, const std::string& rel, const char* type,
                        const char* title) { return Link(LinkTo(request, path), rel, type, title); };
  Value links = Value::array();
  const std::string at = "/ogc/collections/" + map.flight_id;
  links.push_back(link(at, "self", "application/json", "This map"));
  links.push_back(link(at + "/map/tiles", kOgcRel + "tilesets-map", "application/json", "Its tilesets"));
  links.push_back(link("/stac/" + map.flight_id, "describedby", "application/geo+json", "STAC item"));
  for (const PhotoFeatures kind : FeaturesOf(map)) {
    links.push_back(link("/ogc/collections/" + NameOfCollection(map.flight_id, kind), "related",
                         "application/json",
                         kind == PhotoFeatures::kPhotos ? "Its photos" : "Footprints of its photos"));
  }
  Value collection;
  collection["id"] = map.flight_id;
  collection["title"] = map.name;
  collection["extent"] = {
      {"spatial", {{"bbox", Value::array({map.revision.bounds.ToArray()})}, {"crs", kCrs84}}}};
  collection["dataType"] = "map";
  collection["crs"] = {kMercator};
  collection["links"] = links;
  return collection;
}

// Of the map, or of its photos.
Response DescribeCollection(Service& service, const Request& request) {
  const std::string& name = request.Parameter("flight");
  const auto kind = PhotoFeaturesNamed(name);
  const Result<MapView> map = FindMap(service, request, kind ? name.substr(0, name.find('.')) : name);
  if (!map) return Problem(map.error(), request);
  const storage::ShownFlight shown = map->shown();
  if (!kind) return Document(Collection(request, shown));
  if (FeaturesOf(shown).empty())
    return Problem({ErrorCode::kNotFound, "This map was not made of photos.", ""}, request);
  return Document(Value::parse(PhotoCollection(request, shown, *kind)));
}

Response Collections(Service& service, const Request& request) {
  int limit = 50;
  if (const auto text = request.Query("limit")) {
    const auto parsed = std::from_chars(text->data(), text->data() + text->size(), limit);
    if (parsed.ec != std::errc() || parsed.ptr != text->data() + text->size() || limit < 1 || limit > 200) {
      return Problem(
          {ErrorCode::kInvalidArgument, "The parameter \"limit\" must be a whole number from 1 to 200.", ""},
          request);
    }
  }
  std::optional<std::string> cursor;
  if (const auto given = request.Query("cursor")) cursor = *given;
  if (cursor && !storage::IsId(*cursor)) {
    return Problem({ErrorCode::kInvalidArgument, "The parameter \"cursor\" is not one that a list gave.", ""},
                   request);
  }
  const Result<storage::MapPage> page = ListVisibleMaps(service, request, limit, cursor);
  if (!page) return Problem(page.error(), request);
  Value collections = Value::array();
  for (const storage::ShownFlight& map : page->maps) {
    collections.push_back(Collection(request, map));
    for (const PhotoFeatures kind : FeaturesOf(map))
      collections.push_back(Value::parse(PhotoCollection(request, map, kind)));
  }
  const MapView at = Anywhere(request);
  Value links = Value::array({Link(at.Link("/ogc/collections"), "self", "application/json", "This list")});
  if (page->next_cursor) {
    links.push_back(
        Link(at.Link(fmt::format("/ogc/collections?limit={}&cursor={}", limit, *page->next_cursor)), "next",
             "application/json", "The next maps"));
  }
  return Document({{"links", links}, {"collections", collections}});
}

Value TilesetSummary(const MapView& map, int side_px) {
  const std::string at = fmt::format("/ogc/collections/{}/map/tiles/{}", map.id, MatrixSetName(side_px));
  Value tileset;
  tileset["title"] = map.name;
  tileset["dataType"] = "map";
  tileset["crs"] = kMercator;
  if (side_px == kUsualTilePx) {
    tileset["tileMatrixSetURI"] = "http://www.opengis.net/def/tilematrixset/OGC/1.0/WebMercatorQuad";
  }
  Value links = Value::array();
  links.push_back(Link(map.Link(at), "self", "application/json", "This tileset"));
  links.push_back(Link(map.Link("/ogc/tileMatrixSets/" + MatrixSetName(side_px)), kOgcRel + "tiling-scheme",
                       "application/json", "Its tile matrix set"));
  for (const auto& [type, extension] : {std::pair{"image/png", "png"}, std::pair{"image/jpeg", "jpg"}}) {
    Value item = Link(map.Link(at + "/{tileMatrix}/{tileRow}/{tileCol}." + extension), "item", type, "Tiles");
    item["templated"] = true;
    links.push_back(item);
  }
  tileset["links"] = links;
  return tileset;
}

Response Tilesets(const MapView& map) {
  Value links = Value::array(
      {Link(map.Link("/ogc/collections/" + map.id + "/map/tiles"), "self", "application/json", "This list")});
  Value tilesets = Value::array();
  for (const int side_px : map.tile_sizes_px()) tilesets.push_back(TilesetSummary(map, side_px));
  return Document({{"links", links}, {"tilesets", tilesets}});
}

Response TilesetDocument(const MapView& map, int side_px) {
  Value tileset = TilesetSummary(map, side_px);
  Value limits = Value::array();
  const std::vector<TileMatrix> matrices = MatricesOf(map, side_px);
  for (const TileMatrix& matrix : matrices) {
    limits.push_back({{"tileMatrix", std::to_string(matrix.zoom)},
                      {"minTileRow", matrix.min_row},
                      {"maxTileRow", matrix.max_row},
                      {"minTileCol", matrix.min_column},
                      {"maxTileCol", matrix.max_column}});
  }
  tileset["tileMatrixSetLimits"] = limits;
  const auto& [west, south, east, north] = map.revision().bounds;
  tileset["boundingBox"] = {{"lowerLeft", {west, south}}, {"upperRight", {east, north}}, {"crs", kCrs84}};
  tileset["centerPoint"] = {{"coordinates", {(west + east) / 2, (south + north) / 2}},
                            {"crs", kCrs84},
                            {"tileMatrix", std::to_string(matrices.back().zoom)}};
  return Document(tileset);
}

// "WebMercatorQuad" has tiles of 256 pixels; a number behind it is another side.
std::optional<int> SideOf(std::string_view set) {
  constexpr std::string_view kName = "WebMercatorQuad";
  if (!set.starts_with(kName)) return std::nullopt;
  if (set == kName) return 256;
  for (const int side_px : {512, 1024, 2048, 4096}) {
    if (set.substr(kName.size()) == std::to_string(side_px)) return side_px;
  }
  return std::nullopt;
}

Response MatrixSets(const Request& request) {
  const MapView at = Anywhere(request);
  Value sets = Value::array();
  for (const char* id : {"WebMercatorQuad", "WebMercatorQuad512", "WebMercatorQuad1024"}) {
    sets.push_back({{"id", id},
                    {"links", Value::array({Link(at.Link(std::string("/ogc/tileMatrixSets/") + id), "self",
                                                 "application/json", "Definition")})}});
  }
  return Document({{"tileMatrixSets", sets}});
}

Response MatrixSet(const Request& request) {
  const std::string& id = request.Parameter("set");
  const std::optional<int> side_px = SideOf(id);
  if (!side_px) return Problem({ErrorCode::kNotFound, "There is no such tile matrix set.", ""}, request);
  Value matrices = Value::array();
  Value older = Value::array();
  constexpr int kFinest = 24;
  for (int zoom = 0; zoom <= kFinest; ++zoom) {
    const double cell_m = geo::PixelSizeInMercM(zoom, *side_px);
    matrices.push_back({{"id", std::to_string(zoom)},
                        {"scaleDenominator", cell_m / 0.00028},
                        {"cellSize", cell_m},
                        {"cornerOfOrigin", "topLeft"},
                        {"pointOfOrigin", {-geo::kMercHalfWidthM, geo::kMercHalfWidthM}},
                        {"tileWidth", *side_px},
                        {"tileHeight", *side_px},
                        {"matrixWidth", std::uint64_t{1} << zoom},
                        {"matrixHeight", std::uint64_t{1} << zoom}});
    older.push_back({{"type", "TileMatrixType"},
                     {"identifier", std::to_string(zoom)},
                     {"scaleDenominator", cell_m / 0.00028},
                     {"topLeftCorner", {-geo::kMercHalfWidthM, geo::kMercHalfWidthM}},
                     {"tileWidth", *side_px},
                     {"tileHeight", *side_px},
                     {"matrixWidth", std::uint64_t{1} << zoom},
                     {"matrixHeight", std::uint64_t{1} << zoom}});
  }
  Value set;
  set["id"] = id;
  set["title"] = "Google Maps Compatible for the World";
  if (*side_px == 256) {
    set["uri"] = "http://www.opengis.net/def/tilematrixset/OGC/1.0/WebMercatorQuad";
    set["wellKnownScaleSet"] = "http://www.opengis.net/def/wkss/OGC/1.0/GoogleMapsCompatible";
  }
  set["crs"] = kMercator;
  set["orderedAxes"] = {"E", "N"};
  set["tileMatrices"] = matrices;
  // The same in the words of the standard's first version, which programs still go by (GDAL 3.6, and QGIS
  // with it).
  set["type"] = "TileMatrixSetType";
  set["identifier"] = id;
  set["supportedCRS"] = kMercator;
  set["tileMatrix"] = older;
  return Document(set);
}

Result<Response> Tile(Service& service, const Request& request, const MapView& map) {
  TileRequest wanted;
  SKYQUILT_TRY_ASSIGN(wanted.side_px, map.SizeOfSet(request.Parameter("set")));
  // OGC has the row before the column.
  const std::string& last = request.Parameter("column");
  const std::size_t dot = std::min(last.find('.'), last.size());
  SKYQUILT_TRY_ASSIGN(const TilePath path, ParseTilePath(request.Parameter("matrix"), last.substr(0, dot),
                                                         request.Parameter("row") + last.substr(dot)));
  wanted.flight_id = map.id;
  wanted.tile = path.tile;
  wanted.format = path.format;
  if (!path.format) {
    SKYQUILT_TRY_ASSIGN(wanted.format, TileFormatFor(request, *map.tileset));
  }
  wanted.empty = EmptyTile::kNoContent;
  Result<Response> answer = AnswerTile(service, request, wanted);
  if (answer && !path.format) answer->headers.Add("Vary", "Accept");
  return answer;
}

using OfMap = std::function<Response(const MapView&, const Request&)>;

// For whom JSON will do.
Handler AsJson(Handler answer) {
  return [answer = std::move(answer)](const Request& request) {
    const Result<void> takes = CheckTakesJson(request);
    return takes ? answer(request) : Problem(takes.error(), request);
  };
}

}  // namespace

void AddOgcRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/ogc", AsJson(Landing));
  router.AddQuick(Method::kGet, "/ogc/conformance", AsJson(Conformance));
  router.AddQuick(Method::kGet, "/ogc/tileMatrixSets", AsJson(MatrixSets));
  router.AddQuick(Method::kGet, "/ogc/tileMatrixSets/{set}", AsJson(MatrixSet));
  router.Add(Method::kGet, "/ogc/collections",
             AsJson([&](const Request& r) { return Collections(service, r); }));
  const auto of_map = [&](OfMap answer) -> Handler {
    return [&service, answer = std::move(answer)](const Request& request) {
      const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
      return map ? answer(*map, request) : Problem(map.error(), request);
    };
  };
  router.Add(Method::kGet, "/ogc/collections/{flight}",
             AsJson([&](const Request& r) { return DescribeCollection(service, r); }));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles",
             AsJson(of_map([](const MapView& map, const Request&) { return Tilesets(map); })));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles/{set}",
             AsJson(of_map([](const MapView& map, const Request& request) {
               const Result<int> side_px = map.SizeOfSet(request.Parameter("set"));
               return side_px ? TilesetDocument(map, *side_px) : Problem(side_px.error(), request);
             })));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles/{set}/{matrix}/{row}/{column}",
             of_map([&](const MapView& map, const Request& request) {
               return TileResponse(Tile(service, request, map), request);
             }));
}

}  // namespace skyquilt::api
