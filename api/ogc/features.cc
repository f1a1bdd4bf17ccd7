#include "api/ogc/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/common/feature_query.h"
#include "api/common/find_flight.h"
#include "api/http/links.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/ogc/ogc_format.h"
#include "api/routes.h"
#include "api/stac/stac_search.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

using FeatureJson = nlohmann::ordered_json;

constexpr const char* kFeatureType = "application/geo+json";
constexpr const char* kFeatureCrs = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";
constexpr int kUsualFeatures = 100;
constexpr int kMaxFeatures = 10'000;

struct FeatureQuery {
  std::optional<geo::LatLonBounds> bbox;
  std::optional<TimeSpan> datetime;
  int limit = kUsualFeatures;
  std::size_t offset = 0;
};

// A mistyped filter that is passed over would answer everything: the standard wants it refused.
Result<void> CheckFeatureParameters(const Request& request) {
  constexpr std::string_view kKnown[] = {"bbox",   "bbox-crs", "datetime", "limit",
                                         "offset", "crs",      "f",        "token"};
  for (const auto& [name, value] : request.query) {
    if (std::find(std::begin(kKnown), std::end(kKnown), name) == std::end(kKnown)) {
      return Error{ErrorCode::kInvalidArgument,
                   "There is no parameter \"" + name.substr(0, 40) +
                       "\" here. Features are listed by bbox, datetime, limit and offset."};
    }
  }
  for (const char* name : {"bbox-crs", "crs"}) {
    const auto crs = request.Query(name);
    if (crs && *crs != kFeatureCrs)
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("The parameter \"{}\" can only be {}.", name, kFeatureCrs)};
  }
  return {};
}

Result<FeatureQuery> ParseFeatureQuery(const Request& request) {
  SKYQUILT_TRY(CheckFeatureParameters(request));
  FeatureQuery query;
  if (const auto bbox = request.Query("bbox")) {
    SKYQUILT_TRY_ASSIGN(query.bbox, ParseBbox(*bbox));
  }
  if (const auto datetime = request.Query("datetime")) {
    SKYQUILT_TRY_ASSIGN(query.datetime, ParseTimeSpan(*datetime));
  }
  SKYQUILT_TRY_ASSIGN(query.limit,
                      ParseLimit(request.Query("limit").value_or(""), kUsualFeatures, kMaxFeatures));
  if (const auto text = request.Query("offset")) {
    const auto offset = ParseNumber<std::size_t>(*text);
    if (!offset) return Error{ErrorCode::kInvalidArgument, "\"offset\" must be a whole number from 0 on."};
    query.offset = *offset;
  }
  return query;
}

// The photos of the map that a flight shows, as they were written beside it.
Result<FeatureJson> ReadPhotos(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const ShownMap shown, FindShownMap(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const storage::LocalBlob file, FetchProduct(service, shown, "photos.geojson"));
  SKYQUILT_TRY_ASSIGN(const std::string text, storage::ReadWholeFile(file.path));
  FeatureJson json = ParseOrderedJson(text);
  if (!json.is_object() || !json.contains("features") || !json["features"].is_array())
    return Error{ErrorCode::kCorrupt, "The list of photos of this map is damaged.", file.path.string()};
  return std::move(json["features"]);
}

std::optional<geo::LatLonBounds> BoundsOfRing(const FeatureJson& geometry) {
  std::optional<geo::LatLonBounds> bounds;
  if (!geometry.is_object()) return bounds;
  for (const FeatureJson& corner : geometry.at("coordinates").at(0)) {
    const double lon_deg = corner.at(0).get<double>(), lat_deg = corner.at(1).get<double>();
    const geo::LatLonBounds place{lon_deg, lat_deg, lon_deg, lat_deg};
    if (bounds) bounds->Include(place);
    if (!bounds) bounds = place;
  }
  return bounds;
}

// A photo as a feature of one of the collections; null: it has no place in it.
FeatureJson FeatureOf(const FeatureJson& photo, PhotoFeatures kind) {
  const FeatureJson& properties = photo.at("properties");
  FeatureJson feature = {{"type", "Feature"}, {"id", properties.at("name")}};
  if (kind == PhotoFeatures::kFootprints) {
    if (!photo.at("geometry").is_object()) return {};
    feature["geometry"] = photo.at("geometry");
  } else {
    feature["geometry"] = {{"type", "Point"},
                           {"coordinates", {properties.at("camera_lon"), properties.at("camera_lat")}}};
  }
  feature["properties"] = properties;
  return feature;
}

bool IsAsked(const FeatureJson& feature, const FeatureQuery& query) {
  const FeatureJson& geometry = feature.at("geometry");
  if (query.bbox) {
    std::optional<geo::LatLonBounds> bounds;
    if (geometry.at("type") == "Point") {
      const double lon_deg = geometry.at("coordinates").at(0).get<double>();
      const double lat_deg = geometry.at("coordinates").at(1).get<double>();
      bounds = geo::LatLonBounds{lon_deg, lat_deg, lon_deg, lat_deg};
    } else {
      bounds = BoundsOfRing(geometry);
    }
    if (!bounds || !BoxesMeet(*query.bbox, *bounds)) return false;
  }
  if (!query.datetime) return true;
  // What has no time is not left out by one (OGC 17-069r4, 7.15.4).
  const FeatureJson& recorded = feature.at("properties").at("captured_at");
  if (!recorded.is_string()) return true;
  const double lon_deg = feature.at("properties").at("camera_lon").get<double>();
  const auto utc = UtcOfCapture(recorded.get<std::string>(), lon_deg);
  const auto taken = utc ? InstantOf(*utc) : std::nullopt;
  if (!taken) return true;
  return !(query.datetime->from && *taken < *query.datetime->from) &&
         !(query.datetime->to && *taken > *query.datetime->to);
}

FeatureJson FeatureLink(const Request& request, const std::string& path, const char* rel, const char* type) {
  return {{"href", LinkTo(request, path)}, {"rel", rel}, {"type", type}};
}

std::string PathOfCollection(const Request& request) {
  return "/ogc/collections/" + request.Parameter("flight");
}

// The same list from another place on.
std::string PageAt(const Request& request, const FeatureQuery& query, std::size_t offset) {
  std::string path =
      fmt::format("{}/items?limit={}&offset={}", PathOfCollection(request), query.limit, offset);
  for (const char* name : {"bbox", "datetime"}) {
    if (const auto value = request.Query(name)) path += fmt::format("&{}={}", name, EncodedForQuery(*value));
  }
  return path;
}

struct AskedPhotos {
  PhotoFeatures kind;
  FeatureJson photos;
};
Result<AskedPhotos> PhotosOfCollection(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckTakesGeoJson(request));
  const std::string& name = request.Parameter("flight");
  const auto kind = PhotoFeaturesNamed(name);
  if (!kind) {
    return Error{ErrorCode::kNotFound,
                 "This collection has no items. Those with items are named FLIGHT.photos and "
                 "FLIGHT.footprints."};
  }
  SKYQUILT_TRY_ASSIGN(FeatureJson photos, ReadPhotos(service, name.substr(0, name.find('.'))));
  return AskedPhotos{*kind, std::move(photos)};
}

Result<Response> Items(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const FeatureQuery query, ParseFeatureQuery(request));
  SKYQUILT_TRY_ASSIGN(const AskedPhotos asked, PhotosOfCollection(service, request));
  FeatureJson features = FeatureJson::array();
  std::size_t matched = 0;
  for (const FeatureJson& photo : asked.photos) {
    FeatureJson feature = FeatureOf(photo, asked.kind);
    if (feature.is_null() || !IsAsked(feature, query)) continue;
    ++matched;
    if (matched > query.offset && features.size() < static_cast<std::size_t>(query.limit))
      features.push_back(std::move(feature));
  }
  const std::string path = PathOfCollection(request);
  FeatureJson links = FeatureJson::array();
  links.push_back(FeatureLink(request, PageAt(request, query, query.offset), "self", kFeatureType));
  links.push_back(FeatureLink(request, path, "collection", "application/json"));
  if (query.offset < matched && query.offset + features.size() < matched) {
    links.push_back(
        FeatureLink(request, PageAt(request, query, query.offset + features.size()), "next", kFeatureType));
  }
  const std::size_t returned = features.size();
  return NoCacheJson({{"type", "FeatureCollection"},
                      {"features", std::move(features)},
                      {"numberMatched", matched},
                      {"numberReturned", returned},
                      {"timeStamp", FormatTime(storage::Now())},
                      {"links", links}},
                     kFeatureType);
}

Result<Response> Item(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const AskedPhotos asked, PhotosOfCollection(service, request));
  const std::string& id = request.Parameter("feature");
  for (const FeatureJson& photo : asked.photos) {
    if (photo.at("properties").at("name") != id) continue;
    FeatureJson feature = FeatureOf(photo, asked.kind);
    if (feature.is_null()) break;
    const std::string path = PathOfCollection(request);
    feature["links"] = FeatureJson::array(
        {FeatureLink(request, path + "/items/" + EncodedForQuery(id), "self", kFeatureType),
         FeatureLink(request, path, "collection", "application/json")});
    return NoCacheJson(feature, kFeatureType);
  }
  return Error{ErrorCode::kNotFound, "There is no such photo in this collection."};
}

// What is read may have been damaged on the disk: then the answer is that, not a crash.
Handler Guarded(Service& service, Result<Response> (*answer)(Service&, const Request&)) {
  return [&service, answer](const Request& request) -> Result<Response> {
    try {
      return answer(service, request);
    } catch (const FeatureJson::exception& thrown) {
      return Error{ErrorCode::kCorrupt, "The list of photos of this map is damaged.", thrown.what()};
    }
  };
}

}  // namespace

std::optional<PhotoFeatures> PhotoFeaturesNamed(std::string_view collection) {
  const std::size_t dot = collection.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  if (collection.substr(dot) == ".photos") return PhotoFeatures::kPhotos;
  if (collection.substr(dot) == ".footprints") return PhotoFeatures::kFootprints;
  return std::nullopt;
}

std::string NameOfCollection(const std::string& flight_id, PhotoFeatures kind) {
  return flight_id + (kind == PhotoFeatures::kPhotos ? ".photos" : ".footprints");
}

FeatureJson PhotoCollection(const Request& request, const storage::ShownFlight& map, PhotoFeatures kind) {
  const std::string id = NameOfCollection(map.flight_id, kind);
  FeatureJson collection;
  collection["id"] = id;
  collection["title"] =
      map.name + (kind == PhotoFeatures::kPhotos ? ", photos" : ", footprints of the photos");
  collection["itemType"] = "feature";
  collection["extent"]["spatial"] = {{"bbox", FeatureJson::array({GeoJsonBbox(map.revision.bounds)})},
                                     {"crs", kFeatureCrs}};
  if (const auto times = CaptureTimesOf(map.revision)) {
    collection["extent"]["temporal"]["interval"] =
        FeatureJson::array({FeatureJson::array({times->first, times->last})});
  }
  collection["crs"] = {kFeatureCrs};
  const std::string path = "/ogc/collections/" + id;
  collection["links"] = FeatureJson::array({FeatureLink(request, path, "self", "application/json"),
                                            FeatureLink(request, path + "/items", "items", kFeatureType)});
  return collection;
}

void AddFeatureRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/ogc/collections/{flight}/items", Guarded(service, Items));
  router.AddCompute(Method::kGet, "/ogc/collections/{flight}/items/{feature}", Guarded(service, Item));
}

}  // namespace skyquilt::api
