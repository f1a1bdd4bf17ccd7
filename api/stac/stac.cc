#include "api/stac/stac.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/ogc/map_view.h"
#include "api/stac/capture_times.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

Value Link(const std::string& href, const char* rel, const char* type) {
  return {{"rel", rel}, {"href", href}, {"type", type}};
}

// When the photos were taken, earliest and latest; empty where no camera knew it.
std::set<std::string> CaptureTimes(storage::BlobStore& blobs, const std::string& prefix, double lon_deg) {
  const Result<storage::LocalBlob> fetched = blobs.Local(prefix + "photos.geojson");
  std::ifstream file(fetched ? fetched->path : std::filesystem::path(), std::ios::binary);
  const Value photos = Value::parse(file, nullptr, false);
  std::set<std::string> times;
  if (!photos.is_object()) return times;
  for (const Value& photo : photos.value("features", Value::array())) {
    const Value& time = photo.at("properties").at("captured_at");
    const auto utc = time.is_string() ? UtcOfCapture(time.get<std::string>(), lon_deg) : std::nullopt;
    if (!utc) continue;
    times.insert(*utc);
    if (times.size() > 2) times.erase(std::next(times.begin()));
  }
  return times;
}

Value Item(const MapView& map, storage::BlobStore& blobs, const std::string& prefix) {
  const auto& [west, south, east, north] = map.revision().bounds;
  Value ring = {{west, south}, {east, south}, {east, north}, {west, north}, {west, south}};
  Value item;
  item["type"] = "Feature";
  item["stac_version"] = "1.0.0";
  item["stac_extensions"] = {"https://stac-extensions.github.io/projection/v1.1.0/schema.json",
                             "https://stac-extensions.github.io/web-map-links/v1.1.0/schema.json"};
  item["id"] = fmt::format("{}-r{}", map.id, map.revision().revision);
  item["bbox"] = map.revision().bounds.ToArray();
  item["geometry"] = {{"type", "Polygon"}, {"coordinates", Value::array({ring})}};
  item["properties"] = {{"title", map.name},
                        {"datetime", FormatTime(map.revision().created)},
                        {"created", FormatTime(map.revision().created)},
                        {"gsd", map.revision().gsd_m},
                        {"proj:epsg", 3857}};
  if (const std::set<std::string> times = CaptureTimes(blobs, prefix, 0.5 * (west + east)); !times.empty()) {
    item["properties"]["datetime"] = *times.begin();
    item["properties"]["start_datetime"] = *times.begin();
    item["properties"]["end_datetime"] = *times.rbegin();
  }
  Value links = Value::array();
  links.push_back(Link(map.Link("/stac/" + map.id), "self", "application/geo+json"));
  links.push_back(Link(map.Link("/ogc/collections/" + map.id), "related", "application/json"));
  Value xyz = Link(map.Link(fmt::format("/tiles/{}/{{z}}/{{x}}/{{y}}", map.id)), "xyz", "image/jpeg");
  links.push_back(xyz);
  links.push_back(Link(map.Link(fmt::format("/tiles/{}.json", map.id)), "tilejson", "application/json"));
  Value wmts = Link(map.Link("/wmts/" + map.id + "/1.0.0/WMTSCapabilities.xml"), "wmts", "application/xml");
  wmts["wmts:layer"] = "map";
  links.push_back(wmts);
  Value wms = Link(map.Link("/wms/" + map.id), "wms", "image/png");
  wms["wms:layers"] = {"map"};
  links.push_back(wms);
  item["links"] = links;
  const std::string api = "/api/v1/flights/" + map.id;
  const auto asset = [&](const std::string& path, const char* type, const char* title, const char* role) {
    return Value{{"href", map.Link(api + path)}, {"type", type}, {"title", title}, {"roles", {role}}};
  };
  item["assets"] = {
      {"cog",
       asset("/download.tif", "image/tiff; application=geotiff; profile=cloud-optimized", "Map", "data")},
      {"mbtiles", asset("/download.mbtiles", "application/vnd.sqlite3", "Tiles", "data")},
      {"photos", asset("/photos.geojson", "application/geo+json", "Photo footprints", "metadata")},
      {"report", asset("/report", "application/json", "How it was made", "metadata")},
      {"thumbnail", asset("/thumbnail.png", "image/png", "The map, small", "thumbnail")}};
  if (blobs.Find(prefix + "mosaic.pmtiles")) {
    constexpr const char* kPmtiles = "application/vnd.pmtiles";
    item["assets"]["pmtiles"] = asset("/download.pmtiles", kPmtiles, "Tiles", "data");
    item["links"].push_back(Link(map.Link(api + "/download.pmtiles"), "pmtiles", kPmtiles));
  }
  return item;
}

}  // namespace

void AddStacRoute(Router& router, Service& service) {
  router.Add(Method::kGet, "/stac/{flight}", [&](const Request& request) {
    const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
    if (!map) return Problem(map.error(), request);
    Response response =
        Text(200,
             Item(*map, service.store.blobs(), storage::RevisionPrefix(map->id, map->revision().revision))
                 .dump(-1, ' ', false, Value::error_handler_t::replace),
             "application/geo+json");
    response.headers.Add("Cache-Control", "no-cache");
    return response;
  });
}

}  // namespace skyquilt::api
