#include "api/basemap/basemap.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/downloads/send_file.h"
#include "api/http/responses.h"
#include "api/routes.h"

namespace skyquilt::api {
namespace {

struct PublicBasemap {
  std::string_view name;
  std::string_view title;
  std::string_view tiles;
  std::string_view attribution;
  int max_zoom;
};

constexpr PublicBasemap kPublicBasemaps[] = {
    {"openstreetmap", "OpenStreetMap", "https://tile.openstreetmap.org/{z}/{x}/{y}.png",
     "© OpenStreetMap contributors", 19},
    {"opentopomap", "OpenTopoMap", "https://tile.opentopomap.org/{z}/{x}/{y}.png",
     "© OpenStreetMap contributors, SRTM; map style: © OpenTopoMap (CC-BY-SA)", 17},
    {"carto-light", "CARTO light", "https://basemaps.cartocdn.com/light_all/{z}/{x}/{y}.png",
     "© OpenStreetMap contributors, © CARTO", 20},
    {"carto-dark", "CARTO dark", "https://basemaps.cartocdn.com/dark_all/{z}/{x}/{y}.png",
     "© OpenStreetMap contributors, © CARTO", 20},
    {"esri-imagery", "Esri World Imagery",
     "https://server.arcgisonline.com/ArcGIS/rest/services/World_Imagery/MapServer/tile/{z}/{y}/{x}",
     "Esri, Maxar, Earthstar Geographics and the GIS user community", 19},
    {"usgs-imagery", "USGS Imagery (USA)",
     "https://basemap.nationalmap.gov/arcgis/rest/services/USGSImageryOnly/MapServer/tile/{z}/{y}/{x}",
     "USGS The National Map", 16},
};

std::string OriginOf(std::string_view tiles) {
  return std::string(tiles.substr(0, tiles.find('/', tiles.find("//") + 2)));
}

nlohmann::ordered_json OfferedJson(const PublicBasemap& offered) {
  return {{"name", offered.name},
          {"title", offered.title},
          {"tiles", nlohmann::ordered_json::array({offered.tiles})},
          {"attribution", offered.attribution},
          {"maxzoom", offered.max_zoom}};
}

Response Describe(const Basemap& basemap, const Request& request) {
  nlohmann::ordered_json described = {{"tilejson", "3.0.0"}, {"tiles", nlohmann::ordered_json::array()}};
  if (!basemap.tiles.empty()) described["tiles"].push_back(basemap.tiles);
  if (!basemap.pmtiles.empty()) described["pmtiles"] = request.base_path + "/basemap.pmtiles";
  if (!basemap.attribution.empty()) described["attribution"] = basemap.attribution;
  if (basemap.max_zoom > 0) described["maxzoom"] = basemap.max_zoom;
  described["public"] = nlohmann::ordered_json::array();
  for (const PublicBasemap& known : kPublicBasemaps) {
    if (basemap.offers_public) described["public"].push_back(OfferedJson(known));
  }
  return JsonOf(200, described);
}

Result<Response> SendPmtiles(const Basemap& basemap, const Request& request) {
  struct stat status {};
  if (basemap.pmtiles.empty() || stat(basemap.pmtiles.c_str(), &status) != 0) {
    return Error{ErrorCode::kNotFound, "This server has no basemap of its own (serve --basemap)."};
  }
  const std::string etag = fmt::format("\"{:x}-{:x}\"", status.st_mtim.tv_sec, status.st_size);
  return SendFile(request, basemap.pmtiles, "application/vnd.pmtiles", etag);
}

}  // namespace

std::string Basemap::Origins() const {
  if (!offers_public) return OriginOf(tiles);
  std::vector<std::string> origins;
  for (const PublicBasemap& known : kPublicBasemaps) {
    std::string origin = OriginOf(known.tiles);
    if (std::find(origins.begin(), origins.end(), origin) == origins.end())
      origins.push_back(std::move(origin));
  }
  return fmt::format("{}", fmt::join(origins, " "));
}

std::vector<std::string> BasemapNames() {
  std::vector<std::string> names;
  for (const PublicBasemap& known : kPublicBasemaps) names.emplace_back(known.name);
  return names;
}

Result<Basemap> BasemapFrom(const std::string& text, const std::string& attribution) {
  Basemap basemap;
  basemap.attribution = attribution;
  if (text.empty() && !attribution.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "The option --basemap-attribution needs --basemap, whose makers it names."};
  }
  if (text.empty()) return basemap;
  basemap.offers_public = false;
  if (text == "none") return basemap;
  for (const PublicBasemap& known : kPublicBasemaps) {
    if (text != known.name) continue;
    basemap.tiles = known.tiles;
    basemap.max_zoom = known.max_zoom;
    if (attribution.empty()) basemap.attribution = known.attribution;
    return basemap;
  }
  if (text.starts_with("http://") || text.starts_with("https://")) {
    for (const char* part : {"{z}", "{x}", "{y}"}) {
      if (text.find(part) == std::string::npos || text.find_first_of(" \"<>;'") != std::string::npos) {
        return Error{
            ErrorCode::kInvalidArgument,
            "Give --basemap tiles as https://host/path/{z}/{x}/{y}.png, or the path of a PMTiles file."};
      }
    }
    basemap.tiles = text;
    return basemap;
  }
  std::error_code missing;
  if (!std::filesystem::is_regular_file(text, missing)) {
    return Error{
        ErrorCode::kNotFound,
        fmt::format("The basemap file {} does not exist. Check the path given with --basemap, or say one of "
                    "these names: {}.",
                    text, fmt::join(BasemapNames(), ", "))};
  }
  basemap.pmtiles = std::filesystem::absolute(text);
  return basemap;
}

void AddBasemapRoutes(Router& router, Service& service) {
  const Basemap& basemap = service.basemap;
  router
      .Add(Method::kGet, "/basemap.json",
           [basemap](const Request& request) { return Describe(basemap, request); })
      .scope = kEverybody;
  router
      .Add(Method::kGet, "/basemap.pmtiles",
           [basemap](const Request& r) { return Downloaded(SendPmtiles(basemap, r), r); })
      .scope = kEverybody;
}

}  // namespace skyquilt::api
