// STAC API 1.0: the maps that a client may read as one collection, "flights", with item search by box, shape
// and time; and /stac/{flight}, the item of one map. A token sees in all of them what it may read alone.
// https://github.com/radiantearth/stac-api-spec/tree/v1.0.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "api/auth/flight_access.h"
#include "api/common/find_flight.h"
#include "api/http/http_message.h"
#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/stac/stac_search.h"
#include "api/surface/map_surface.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/pipeline/report/map_quality.h"
#include "storage/catalogue/catalogue.h"
#include "storage/exports/warped/warp_tiles.h"

namespace skyquilt::api {
namespace {

using StacJson = nlohmann::ordered_json;

constexpr const char* kJsonType = "application/json";
constexpr const char* kGeoJsonType = "application/geo+json";
constexpr int kRowsAtOnce = 1000;  // of the catalogue, while a search looks for what fits

StacJson StacLink(const Request& request, const std::string& path, const char* rel, const char* type) {
  return {{"rel", rel}, {"href", LinkTo(request, path)}, {"type", type}};
}

StacJson ConformanceClasses() {
  return {"https://api.stacspec.org/v1.0.0/core",
          "https://api.stacspec.org/v1.0.0/collections",
          "https://api.stacspec.org/v1.0.0/ogcapi-features",
          "https://api.stacspec.org/v1.0.0/item-search",
          "http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/core",
          "http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/geojson"};
}

std::string CollectionPath() { return std::string("/stac/collections/") + kStacCollection; }

StacJson Rectangle(double west, double south, double east, double north) {
  const StacJson ring = {{west, south}, {east, south}, {east, north}, {west, north}, {west, south}};
  return StacJson::array({ring});
}

// Across the antimeridian one rectangle on either side of it (RFC 7946, section 3.1.9).
StacJson GeometryOf(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  if (east <= 180.0) return {{"type", "Polygon"}, {"coordinates", Rectangle(west, south, east, north)}};
  return {{"type", "MultiPolygon"},
          {"coordinates", StacJson::array({Rectangle(west, south, 180.0, north),
                                           Rectangle(-180.0, south, east - 360.0, north)})}};
}

StacJson PropertiesOf(const storage::ShownFlight& map) {
  const std::string created = FormatTime(map.revision.created);
  StacJson properties = {{"title", map.name},
                         {"datetime", created},
                         {"created", created},
                         {"gsd", map.revision.gsd_m},
                         {"proj:epsg", 3857}};
  if (!map.tags.empty()) properties["keywords"] = map.tags;
  if (const auto times = CaptureTimesOf(map.revision)) {
    properties["datetime"] = times->first;
    properties["start_datetime"] = times->first;
    properties["end_datetime"] = times->last;
  }
  // The same numbers and words that report.json and the command line have; left out where nothing supports
  // one.
  if (const auto quality = pipeline::ParseQuality(map.revision.quality)) {
    const auto& [status, absolute, relative, limits] = *quality;
    properties["description"] = pipeline::QualityInWords(*quality);
    properties["skyquilt:status"] = pipeline::NameOf(status);
    if (absolute.sigma_m) {
      properties["skyquilt:accuracy_m"] = *absolute.sigma_m;
      properties["skyquilt:accuracy_by"] = pipeline::NameOf(absolute.by);
    }
    if (relative.error_m) properties["skyquilt:relative_error_m"] = *relative.error_m;
    if (relative.error_px) {
      properties["skyquilt:relative_error_px"] = *relative.error_px;
      properties["skyquilt:relative_error_by"] = pipeline::NameOf(relative.by);
    }
  }
  // Of imported maps the resolution may not be known; STAC wants one above zero or none.
  if (!(map.revision.gsd_m > 0.0)) properties.erase("gsd");
  return properties;
}

// "ID-r3": another revision is another item.
std::string StacItemId(const storage::ShownFlight& map) {
  return fmt::format("{}-r{}", map.flight_id, map.revision.revision);
}

// A map as a STAC 1.0 item: where it is, when its photos were taken, and every way to have it. `surfaces`:
// the heights that the map has beside it.
// https://github.com/radiantearth/stac-spec/blob/v1.0.0/item-spec/item-spec.md
StacJson StacItem(const Request& request, const storage::ShownFlight& map,
                  const std::vector<Surface>& surfaces) {
  const std::string& id = map.flight_id;
  StacJson item;
  item["type"] = "Feature";
  item["stac_version"] = "1.0.0";
  item["stac_extensions"] = {"https://stac-extensions.github.io/projection/v1.1.0/schema.json",
                             "https://stac-extensions.github.io/web-map-links/v1.1.0/schema.json"};
  item["id"] = StacItemId(map);
  item["collection"] = kStacCollection;
  item["bbox"] = GeoJsonBbox(map.revision.bounds);
  item["geometry"] = GeometryOf(map.revision.bounds);
  item["properties"] = PropertiesOf(map);
  const std::string collection = CollectionPath();
  StacJson links = StacJson::array();
  links.push_back(StacLink(request, collection + "/items/" + StacItemId(map), "self", kGeoJsonType));
  links.push_back(StacLink(request, collection, "parent", kJsonType));
  links.push_back(StacLink(request, collection, "collection", kJsonType));
  links.push_back(StacLink(request, "/stac", "root", kJsonType));
  links.push_back(StacLink(request, "/ogc/collections/" + id, "related", kJsonType));
  links.push_back(StacLink(request, fmt::format("/tiles/{}/{{z}}/{{x}}/{{y}}", id), "xyz", "image/jpeg"));
  links.push_back(StacLink(request, fmt::format("/tiles/{}.json", id), "tilejson", kJsonType));
  // Of these two the type is what clients are to ask tiles and pictures as (web-map-links).
  StacJson wmts = StacLink(request, "/wmts/" + id + "/1.0.0/WMTSCapabilities.xml", "wmts", "image/png");
  wmts["wmts:layer"] = "map";
  links.push_back(wmts);
  StacJson wms = StacLink(request, "/wms/" + id, "wms", "image/png");
  wms["wms:layers"] = {"map"};
  wms["wms:transparent"] = true;
  links.push_back(wms);
  const std::string api = "/api/v1/flights/" + id;
  constexpr const char* kPmtiles = "application/vnd.pmtiles";
  links.push_back(StacLink(request, api + "/download.pmtiles", "pmtiles", kPmtiles));
  const auto asset = [&](const std::string& path, const char* type, const char* title, const char* role) {
    return StacJson{
        {"href", LinkTo(request, api + path)}, {"type", type}, {"title", title}, {"roles", {role}}};
  };
  item["assets"] = {{"cog", asset("/download.tif", kCogType, "Map", "data")},
                    {"mbtiles", asset("/download.mbtiles", "application/vnd.sqlite3", "Tiles", "data")},
                    {"pmtiles", asset("/download.pmtiles", kPmtiles, "Tiles", "data")},
                    {"photos", asset("/photos.geojson", kGeoJsonType, "Photo footprints", "metadata")},
                    {"report", asset("/report", kJsonType, "How it was made", "metadata")},
                    {"thumbnail", asset("/thumbnail.png", "image/png", "The map, small", "thumbnail")}};
  for (const Surface surface : surfaces) {
    const SurfaceFiles& files = FilesOf(surface);
    StacJson& heights = item["assets"][files.name];
    heights = asset(fmt::format("/{}", files.heights), kCogType, files.title, "data");
    // Their cells are of a zone, whatever the properties say of the map.
    if (const Result<int> epsg = storage::UtmEpsg(map.revision.bounds.Middle())) heights["proj:epsg"] = *epsg;
  }
  item["links"] = links;
  return item;
}

Response StacRoot(const Request& request) {
  StacJson links = StacJson::array();
  links.push_back(StacLink(request, "/stac", "self", kJsonType));
  links.push_back(StacLink(request, "/stac", "root", kJsonType));
  links.push_back(
      StacLink(request, "/openapi.json", "service-desc", "application/vnd.oai.openapi+json;version=3.1"));
  links.push_back(StacLink(request, "/docs", "service-doc", "text/html"));
  links.push_back(StacLink(request, "/stac/conformance", "conformance", kJsonType));
  links.push_back(StacLink(request, "/stac/collections", "data", kJsonType));
  links.push_back(StacLink(request, CollectionPath(), "child", kJsonType));
  for (const char* method : {"GET", "POST"}) {
    links.push_back(StacLink(request, "/stac/search", "search", kGeoJsonType));
    links.back()["method"] = method;
  }
  return NoCacheJson({{"type", "Catalog"},
                      {"stac_version", "1.0.0"},
                      {"id", "skyquilt"},
                      {"title", "Skyquilt"},
                      {"description", "Maps made of aerial photos"},
                      {"conformsTo", ConformanceClasses()},
                      {"links", links}});
}

// Where all maps lie, and when their photos were taken.
struct WholeExtent {
  std::optional<geo::LatLonBounds> bounds;
  std::optional<std::string> first, last;
};
Result<WholeExtent> ExtentOfAll(Service& service, const Request& request) {
  WholeExtent whole;
  std::optional<std::string> cursor;
  do {
    SKYQUILT_TRY_ASSIGN(const storage::MapPage page, ListVisibleMaps(service, request, kRowsAtOnce, cursor));
    for (const storage::ShownFlight& map : page.maps) {
      if (!LiesSomewhere(map.revision.bounds)) continue;
      if (whole.bounds) whole.bounds->Include(map.revision.bounds);
      if (!whole.bounds) whole.bounds = map.revision.bounds;
      const auto times = CaptureTimesOf(map.revision);
      if (!times) continue;
      if (!whole.first || times->first < *whole.first) whole.first = times->first;
      if (!whole.last || times->last > *whole.last) whole.last = times->last;
    }
    cursor = page.next_cursor;
  } while (cursor);
  return whole;
}

Result<StacJson> TheCollection(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const WholeExtent whole, ExtentOfAll(service, request));
  const geo::LatLonBounds bounds = whole.bounds.value_or(geo::LatLonBounds{-180.0, -90.0, 180.0, 90.0});
  const auto time_or_null = [](const std::optional<std::string>& time) {
    return time ? StacJson(*time) : StacJson();
  };
  StacJson links = StacJson::array();
  links.push_back(StacLink(request, CollectionPath(), "self", kJsonType));
  links.push_back(StacLink(request, "/stac", "root", kJsonType));
  links.push_back(StacLink(request, "/stac", "parent", kJsonType));
  links.push_back(StacLink(request, CollectionPath() + "/items", "items", kGeoJsonType));
  StacJson collection;
  collection["type"] = "Collection";
  collection["stac_version"] = "1.0.0";
  collection["id"] = kStacCollection;
  collection["title"] = "Flights";
  collection["description"] = "The finished map of each flight";
  collection["license"] = "proprietary";
  collection["extent"] = {
      {"spatial", {{"bbox", StacJson::array({GeoJsonBbox(bounds)})}}},
      {"temporal",
       {{"interval",
         StacJson::array({StacJson::array({time_or_null(whole.first), time_or_null(whole.last)})})}}}};
  collection["links"] = links;
  return collection;
}

Result<Response> CollectionDocument(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const StacJson collection, TheCollection(service, request));
  return NoCacheJson(collection);
}

Result<Response> CollectionList(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const StacJson collection, TheCollection(service, request));
  StacJson links = StacJson::array();
  links.push_back(StacLink(request, "/stac/collections", "self", kJsonType));
  links.push_back(StacLink(request, "/stac", "root", kJsonType));
  return NoCacheJson({{"collections", StacJson::array({collection})}, {"links", links}});
}

struct FoundMaps {
  std::vector<storage::ShownFlight> maps;
  std::optional<std::string> next_cursor;
};
Result<FoundMaps> Find(Service& service, const Request& request, const StacSearch& search) {
  FoundMaps found;
  std::optional<std::string> cursor = search.cursor;
  do {
    SKYQUILT_TRY_ASSIGN(storage::MapPage page, ListVisibleMaps(service, request, kRowsAtOnce, cursor));
    for (storage::ShownFlight& map : page.maps) {
      if (!search.Finds(map)) continue;
      if (static_cast<int>(found.maps.size()) == search.limit) {
        found.next_cursor = found.maps.back().flight_id;
        return found;
      }
      found.maps.push_back(std::move(map));
    }
    cursor = page.next_cursor;
  } while (cursor);
  return found;
}

Result<StacJson> ItemOf(Service& service, const Request& request, const storage::ShownFlight& map) {
  SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                      service.surfaces.Of(map.flight_id, map.revision.revision));
  return StacItem(request, map, surfaces);
}

// `next`: the link to the next page, with its cursor.
using NextLink = std::function<StacJson(const std::string& cursor)>;

Result<Response> AnswerSearch(Service& service, const Request& request, const Result<StacSearch>& search,
                              const std::string& self, const NextLink& next) {
  if (!search) return search.error();
  SKYQUILT_TRY_ASSIGN(const FoundMaps found, Find(service, request, *search));
  StacJson features = StacJson::array();
  for (const storage::ShownFlight& map : found.maps) {
    SKYQUILT_TRY_ASSIGN(StacJson item, ItemOf(service, request, map));
    features.push_back(std::move(item));
  }
  StacJson links = StacJson::array();
  links.push_back(StacLink(request, "/stac", "root", kJsonType));
  links.push_back(StacLink(request, self, "self", kGeoJsonType));
  if (found.next_cursor) links.push_back(next(*found.next_cursor));
  return NoCacheJson({{"type", "FeatureCollection"},
                      {"features", features},
                      {"numberReturned", found.maps.size()},
                      {"links", links}},
                     kGeoJsonType);
}

// The address that was asked for, with another cursor; the token is put behind it as in all our addresses.
std::string SameSearch(const Request& request, const std::string& path, const std::string& cursor) {
  std::string address = path + "?";
  for (const auto& [name, value] : request.query) {
    if (name == "cursor" || name == "token") continue;
    address += EncodedForQuery(name) + "=" + EncodedForQuery(value) + "&";
  }
  return address + "cursor=" + cursor;
}

Result<Response> SearchByAddress(Service& service, const Request& request, const std::string& path,
                                 Result<StacSearch> search) {
  return AnswerSearch(service, request, search, path, [&](const std::string& cursor) {
    StacJson link = StacLink(request, SameSearch(request, path, cursor), "next", kGeoJsonType);
    link["method"] = "GET";
    return link;
  });
}

Result<Response> SearchByBody(Service& service, const Request& request, const std::string& body) {
  return AnswerSearch(service, request, ParseStacBody(body), "/stac/search", [&](const std::string& cursor) {
    StacJson link = StacLink(request, "/stac/search", "next", kGeoJsonType);
    link["method"] = "POST";
    link["body"] = ParseOrderedJson(body);
    link["body"]["cursor"] = cursor;
    return link;
  });
}

// Of the map that a flight shows.
Result<Response> AnswerItem(Service& service, const Request& request, const std::string& flight_id,
                            const std::string& item_id) {
  const auto shown = [&]() -> Result<storage::ShownFlight> {
    SKYQUILT_TRY(CheckId(flight_id, "flight"));
    SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
    SKYQUILT_TRY_ASSIGN(const std::optional<storage::Revision> revision,
                        service.catalogue.ActiveRevision(flight_id));
    if (!revision) return Error{ErrorCode::kNotFound, "This flight has no map yet."};
    return storage::ShownFlight{flight_id, flight.name, *revision};
  }();
  if (!shown) return shown.error();
  if (!item_id.empty() && item_id != StacItemId(*shown)) {
    return Error{ErrorCode::kNotFound,
                 "This item is no more: the flight shows another map now. It is " + StacItemId(*shown) + "."};
  }
  SKYQUILT_TRY_ASSIGN(const StacJson item, ItemOf(service, request, *shown));
  return NoCacheJson(item, kGeoJsonType);
}

}  // namespace

void AddStacRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/stac", StacRoot);
  router.AddQuick(Method::kGet, "/stac/conformance", [](const Request&) {
    return NoCacheJson({{"conformsTo", ConformanceClasses()}});
  });
  router.Add(Method::kGet, "/stac/collections", On(service, CollectionList));
  router.Add(Method::kGet, CollectionPath(), On(service, CollectionDocument));
  router.Add(Method::kGet, CollectionPath() + "/items", [&](const Request& request) {
    return SearchByAddress(service, request, CollectionPath() + "/items", ParseStacQuery(request));
  });
  router.Add(Method::kGet, CollectionPath() + "/items/{item}", [&](const Request& request) {
    const std::string& item = request.Parameter("item");
    return AnswerItem(service, request, item.substr(0, item.find('-')), item);
  });
  router.Add(Method::kGet, "/stac/search", [&](const Request& request) {
    return SearchByAddress(service, request, "/stac/search", ParseStacQuery(request));
  });
  router
      .AddBody(Method::kPost, "/stac/search", On(service, SearchByBody),
               "Send the search as JSON, with \"Content-Type: application/json\".")
      .scope = storage::Scope::kRead;  // a question, too long for an address
  router.Add(Method::kGet, "/stac/{flight}", [&](const Request& request) {
    return AnswerItem(service, request, request.Parameter("flight"), "");
  });
}

}  // namespace skyquilt::api
