// OGC API - Tiles 1.0 at /ogc: landing page, conformance, collections (one a map) with their tilesets, tile
// matrix sets, and tiles by row and column. OGC 20-057.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "api/auth/flight_access.h"
#include "api/common/feature_query.h"
#include "api/common/find_flight.h"
#include "api/grids/grid_tiles.h"
#include "api/http/parameters.h"
#include "api/json/json_codec.h"
#include "api/ogc/features.h"
#include "api/ogc/matrix_sets.h"
#include "api/ogc/ogc_format.h"
#include "api/routes.h"
#include "api/surface/map_surface.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "api/views/map_view.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_format.h"
#include "storage/exports/warped/warp_tiles.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

// The systems that a map is drawn in without asking twice: its own first, then those of degrees and of its
// zone.
Value CrsListOf(const storage::Revision& revision) {
  Value list = {kMercatorUri, kCrs84Uri, "http://www.opengis.net/def/crs/EPSG/0/4326"};
  if (const Result<int> epsg = storage::UtmEpsg(revision.bounds.Middle()))
    list.push_back(fmt::format("http://www.opengis.net/def/crs/EPSG/0/{}", *epsg));
  return list;
}

Response Landing(const Request& request) {
  const char* const json = "application/json";
  Value links = Value::array();
  links.push_back(OgcLink(request, "/ogc", "self", json, "This document"));
  links.push_back(OgcLink(request, "/openapi.json", "service-desc",
                          "application/vnd.oai.openapi+json;version=3.1", "The API"));
  links.push_back(OgcLink(request, "/docs", "service-doc", "text/html", "The API, to read"));
  for (const std::string& rel : {std::string(), kOgcRel})
    links.push_back(OgcLink(request, "/ogc/conformance", rel + "conformance", json, "Conformance classes"));
  for (const std::string& rel : {std::string(), kOgcRel})
    links.push_back(OgcLink(request, "/ogc/collections", rel + "data", json, "Maps"));
  links.push_back(
      OgcLink(request, "/ogc/tileMatrixSets", kOgcRel + "tiling-schemes", json, "Tile matrix sets"));
  return NoCacheJson(
      {{"title", "Skyquilt"}, {"description", "Maps made of aerial photos"}, {"links", links}});
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
  // OGC 20-058 writes them with https.
  for (const char* name : {"core", "collection-map", "scaling", "display-resolution", "spatial-subsetting",
                           "crs", "background", "png", "jpeg"}) {
    classes.push_back(std::string("https://www.opengis.net/spec/ogcapi-maps-1/1.0/conf/") + name);
  }
  return NoCacheJson({{"conformsTo", classes}});
}

// Imported maps have no photos.
std::span<const PhotoFeatures> FeaturesOf(const storage::ShownFlight& map) {
  if (map.revision.photos_total == 0) return {};
  return kPhotoFeatures;
}

Value Collection(const Request& request, const storage::ShownFlight& map,
                 const std::vector<Surface>& surfaces) {
  const auto link = [&](const std::string& path, const std::string& rel, const char* type,
                        const char* title) { return OgcLink(request, path, rel, type, title); };
  Value links = Value::array();
  const std::string at = "/ogc/collections/" + map.flight_id;
  links.push_back(link(at, "self", "application/json", "This map"));
  for (const image::PictureFormatRow& row : image::kPictureFormats) {
    const bool is_first = &row == &image::kPictureFormats.front();  // which comes without being asked for
    links.push_back(link(at + (is_first ? "/map" : std::string("/map?f=") + row.name), kOgcRel + "map",
                         row.content_type, "This map as a picture"));
  }
  links.push_back(link(at + "/map/tiles", kOgcRel + "tilesets-map", "application/json", "Its tilesets"));
  links.push_back(link("/stac/" + map.flight_id, "describedby", "application/geo+json", "STAC item"));
  for (const Surface surface : surfaces) {
    links.push_back(link(fmt::format("/api/v1/flights/{}/{}", map.flight_id, FilesOf(surface).heights),
                         "enclosure", kCogType, FilesOf(surface).title));
  }
  for (const PhotoFeatures kind : FeaturesOf(map)) {
    links.push_back(link("/ogc/collections/" + NameOfCollection(map.flight_id, kind), "related",
                         "application/json",
                         kind == PhotoFeatures::kPhotos ? "Its photos" : "Footprints of its photos"));
  }
  Value collection;
  collection["id"] = map.flight_id;
  collection["title"] = map.name;
  const auto [low, high] = geo::MercFromLatLonBounds(map.revision.bounds);
  collection["extent"] = {
      {"spatial",
       {{"bbox", Value::array({GeoJsonBbox(map.revision.bounds)})},
        {"crs", kCrs84Uri},
        {"storageCrsBbox", Value::array({Value::array({low.x(), low.y(), high.x(), high.y()})})}}}};
  collection["dataType"] = "map";
  collection["crs"] = CrsListOf(map.revision);
  collection["storageCrs"] = kMercatorUri;
  collection["links"] = links;
  return collection;
}

// Of the map, or of its photos.
Result<Response> DescribeCollection(Service& service, const Request& request) {
  const std::string& name = request.Parameter("flight");
  const auto kind = PhotoFeaturesNamed(name);
  SKYQUILT_TRY_ASSIGN(const MapView map,
                      FindMap(service, request, kind ? name.substr(0, name.find('.')) : name));
  const storage::ShownFlight shown = map.shown();
  if (!kind) {
    SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                        service.surfaces.Of(shown.flight_id, shown.revision.revision));
    return NoCacheJson(Collection(request, shown, surfaces));
  }
  if (FeaturesOf(shown).empty()) return Error{ErrorCode::kNotFound, "This map was not made of photos."};
  return NoCacheJson(PhotoCollection(request, shown, *kind));
}

Result<Response> Collections(Service& service, const Request& request) {
  constexpr int kUsualMaps = 50, kMaxMaps = 200;
  SKYQUILT_TRY_ASSIGN(const int limit, ParseLimit(request.Query("limit").value_or(""), kUsualMaps, kMaxMaps));
  SKYQUILT_TRY_ASSIGN(const auto cursor, ParseCursor(request.Query("cursor")));
  SKYQUILT_TRY_ASSIGN(const storage::MapPage page, ListVisibleMaps(service, request, limit, cursor));
  Value collections = Value::array();
  for (const storage::ShownFlight& map : page.maps) {
    SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                        service.surfaces.Of(map.flight_id, map.revision.revision));
    collections.push_back(Collection(request, map, surfaces));
    for (const PhotoFeatures kind : FeaturesOf(map))
      collections.push_back(PhotoCollection(request, map, kind));
  }
  Value links = Value::array({OgcLink(request, "/ogc/collections", "self", "application/json", "This list")});
  if (page.next_cursor) {
    links.push_back(OgcLink(request,
                            fmt::format("/ogc/collections?limit={}&cursor={}", limit, *page.next_cursor),
                            "next", "application/json", "The next maps"));
  }
  return NoCacheJson({{"links", links}, {"collections", collections}});
}

Result<Response> GridTile(Service& service, const Request& request, const MapView& map, const MapGrid& grid,
                          const TileNumbers& numbers) {
  GridTileRequest wanted{map.id, grid, numbers.z, numbers.x, numbers.y, numbers.format};
  if (!numbers.format) {
    SKYQUILT_TRY_ASSIGN(wanted.format, TileFormatFor(request, *map.tileset));
  }
  wanted.empty = EmptyTile::kNoContent;
  Result<Response> answer = AnswerGridTile(service, request, wanted);
  if (answer && !numbers.format) TellByAccept(*answer);
  return answer;
}

Result<Response> Tile(Service& service, const Request& request, const MapView& map) {
  SKYQUILT_TRY_ASSIGN(const MapSet set, map.SetNamed(request.Parameter("set")));
  // OGC has the row before the column.
  const std::string& last = request.Parameter("column");
  const std::size_t dot = std::min(last.find('.'), last.size());
  const std::string y = request.Parameter("row") + last.substr(dot);
  if (set.grid) {
    SKYQUILT_TRY_ASSIGN(const TileNumbers numbers,
                        ParseTileNumbers(request.Parameter("matrix"), last.substr(0, dot), y));
    return GridTile(service, request, map, *set.grid, numbers);
  }
  TileRequest wanted;
  wanted.side_px = set.side_px;
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("matrix"), last.substr(0, dot), y));
  wanted.flight_id = map.id;
  wanted.tile = path.tile;
  wanted.format = path.format;
  if (!path.format) {
    SKYQUILT_TRY_ASSIGN(wanted.format, TileFormatFor(request, *map.tileset));
  }
  wanted.empty = EmptyTile::kNoContent;
  Result<Response> answer = AnswerTile(service, request, wanted);
  if (answer && !path.format) TellByAccept(*answer);
  return answer;
}

using OfMap = std::function<Result<Response>(const MapView&, const Request&)>;

// For whom JSON will do.
Handler AsJson(Handler answer) {
  return [answer = std::move(answer)](const Request& request) -> Result<Response> {
    SKYQUILT_TRY(CheckTakesJson(request));
    return answer(request);
  };
}

}  // namespace

void AddOgcRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/ogc", AsJson(Landing));
  router.AddQuick(Method::kGet, "/ogc/conformance", AsJson(Conformance));
  router.AddQuick(Method::kGet, "/ogc/tileMatrixSets", AsJson(MatrixSetList));
  router.AddQuick(Method::kGet, "/ogc/tileMatrixSets/{set}", AsJson(MatrixSetDocument));
  router.Add(Method::kGet, "/ogc/collections",
             AsJson([&](const Request& r) { return Collections(service, r); }));
  const auto of_map = [&](OfMap answer) -> Handler {
    return [&service, answer = std::move(answer)](const Request& request) -> Result<Response> {
      SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, request.Parameter("flight")));
      return answer(map, request);
    };
  };
  router.Add(Method::kGet, "/ogc/collections/{flight}",
             AsJson([&](const Request& r) { return DescribeCollection(service, r); }));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles",
             AsJson(of_map([](const MapView& map, const Request&) { return TilesetList(map); })));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles/{set}",
             AsJson(of_map([](const MapView& map, const Request& request) -> Result<Response> {
               SKYQUILT_TRY_ASSIGN(const MapSet set, map.SetNamed(request.Parameter("set")));
               return TilesetDocument(map, set);
             })));
  router.Add(Method::kGet, "/ogc/collections/{flight}/map/tiles/{set}/{matrix}/{row}/{column}",
             of_map([&](const MapView& map, const Request& request) { return Tile(service, request, map); }));
}

}  // namespace skyquilt::api
