#include "api/stac/stac_item.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/common/find_flight.h"
#include "api/http/links.h"
#include "api/json/json_codec.h"
#include "api/stac/stac_search.h"
#include "core/pipeline/report/map_quality.h"
#include "storage/exports/warped/warp_tiles.h"

namespace skyquilt::api {
namespace {

using ItemJson = nlohmann::ordered_json;

ItemJson ItemLink(const std::string& href, const char* rel, const char* type) {
  return {{"rel", rel}, {"href", href}, {"type", type}};
}

ItemJson Rectangle(double west, double south, double east, double north) {
  const ItemJson ring = {{west, south}, {east, south}, {east, north}, {west, north}, {west, south}};
  return ItemJson::array({ring});
}

// Across the antimeridian one rectangle on either side of it (RFC 7946, section 3.1.9).
ItemJson GeometryOf(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  if (east <= 180.0) return {{"type", "Polygon"}, {"coordinates", Rectangle(west, south, east, north)}};
  return {{"type", "MultiPolygon"},
          {"coordinates", ItemJson::array({Rectangle(west, south, 180.0, north),
                                           Rectangle(-180.0, south, east - 360.0, north)})}};
}

ItemJson PropertiesOf(const storage::ShownFlight& map) {
  const std::string created = FormatTime(map.revision.created);
  ItemJson properties = {{"title", map.name},
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

}  // namespace

std::string StacItemId(const storage::ShownFlight& map) {
  return fmt::format("{}-r{}", map.flight_id, map.revision.revision);
}

ItemJson StacItem(const Request& request, const storage::ShownFlight& map,
                  const std::vector<Surface>& surfaces) {
  const std::string& id = map.flight_id;
  const auto to = [&](const std::string& path) { return LinkTo(request, path); };
  ItemJson item;
  item["type"] = "Feature";
  item["stac_version"] = "1.0.0";
  item["stac_extensions"] = {"https://stac-extensions.github.io/projection/v1.1.0/schema.json",
                             "https://stac-extensions.github.io/web-map-links/v1.1.0/schema.json"};
  item["id"] = StacItemId(map);
  item["collection"] = kStacCollection;
  item["bbox"] = GeoJsonBbox(map.revision.bounds);
  item["geometry"] = GeometryOf(map.revision.bounds);
  item["properties"] = PropertiesOf(map);
  const std::string collection = std::string("/stac/collections/") + kStacCollection;
  ItemJson links = ItemJson::array();
  links.push_back(ItemLink(to(collection + "/items/" + StacItemId(map)), "self", "application/geo+json"));
  links.push_back(ItemLink(to(collection), "parent", "application/json"));
  links.push_back(ItemLink(to(collection), "collection", "application/json"));
  links.push_back(ItemLink(to("/stac"), "root", "application/json"));
  links.push_back(ItemLink(to("/ogc/collections/" + id), "related", "application/json"));
  links.push_back(ItemLink(to(fmt::format("/tiles/{}/{{z}}/{{x}}/{{y}}", id)), "xyz", "image/jpeg"));
  links.push_back(ItemLink(to(fmt::format("/tiles/{}.json", id)), "tilejson", "application/json"));
  // Of these two the type is what clients are to ask tiles and pictures as (web-map-links).
  ItemJson wmts = ItemLink(to("/wmts/" + id + "/1.0.0/WMTSCapabilities.xml"), "wmts", "image/png");
  wmts["wmts:layer"] = "map";
  links.push_back(wmts);
  ItemJson wms = ItemLink(to("/wms/" + id), "wms", "image/png");
  wms["wms:layers"] = {"map"};
  wms["wms:transparent"] = true;
  links.push_back(wms);
  const std::string api = "/api/v1/flights/" + id;
  constexpr const char* kPmtiles = "application/vnd.pmtiles";
  links.push_back(ItemLink(to(api + "/download.pmtiles"), "pmtiles", kPmtiles));
  const auto asset = [&](const std::string& path, const char* type, const char* title, const char* role) {
    return ItemJson{{"href", to(api + path)}, {"type", type}, {"title", title}, {"roles", {role}}};
  };
  item["assets"] = {
      {"cog", asset("/download.tif", kCogType, "Map", "data")},
      {"mbtiles", asset("/download.mbtiles", "application/vnd.sqlite3", "Tiles", "data")},
      {"pmtiles", asset("/download.pmtiles", kPmtiles, "Tiles", "data")},
      {"photos", asset("/photos.geojson", "application/geo+json", "Photo footprints", "metadata")},
      {"report", asset("/report", "application/json", "How it was made", "metadata")},
      {"thumbnail", asset("/thumbnail.png", "image/png", "The map, small", "thumbnail")}};
  for (const Surface surface : surfaces) {
    const SurfaceFiles& files = FilesOf(surface);
    ItemJson& heights = item["assets"][files.name];
    heights = asset(fmt::format("/{}", files.heights), kCogType, files.title, "data");
    // Their cells are of a zone, whatever the properties say of the map.
    if (const Result<int> epsg = storage::UtmEpsg(map.revision.bounds.Middle())) heights["proj:epsg"] = *epsg;
  }
  item["links"] = links;
  return item;
}

}  // namespace skyquilt::api
