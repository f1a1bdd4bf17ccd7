// STAC API 1.0: the maps that a client may read as one collection, "flights", with item search by box, shape
// and time; and /stac/{flight}, the item of one map. A token sees in all of them what it may read alone.
// https://github.com/radiantearth/stac-api-spec/tree/v1.0.0

#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/stac/stac_item.h"
#include "api/stac/stac_search.h"
#include "api/surface/map_surface.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

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
