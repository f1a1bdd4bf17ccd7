// What can be known of the indices of a map: GET /api/v1/flights/{flight}/bands (its bands, the indices that
// can be made of them, the colours there are), /legend.svg and .png, /zones. Index tiles are tiles
// (api/tiles), values at a place and within a polygon are api/flights' point and statistics. Any thread.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "api/common/index_look.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/indices/index_legend.h"
#include "api/routes.h"
#include "api/tiles/index_values.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/indices/value_summary.h"
#include "storage/rasters/class_outlines.h"

namespace skyquilt::api {
namespace {

constexpr int kMinZones = 2, kMaxZones = 9;
constexpr int kMaxZoneCells = 2000;   // on the longer side of the grid
constexpr int kUsualZoneCells = 400;  // unless a resolution is said
constexpr int kMinPatchCells = 12;    // smaller patches become part of what surrounds them

struct ZoneRequest {
  IndexLook look;
  int classes = 5;
  std::optional<double> resolution_m;  // of a cell, on the ground
  storage::OutlineFormat format = storage::OutlineFormat::kGeoJson;
};

Error BadZones(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<ZoneRequest> ParseZones(const Request& request) {
  SKYQUILT_TRY_ASSIGN(IndexLook look, LookRequiredIn(request));
  ZoneRequest wanted{.look = std::move(look), .resolution_m = std::nullopt};
  if (const auto classes = request.Query("classes")) {
    const std::optional<int> number = ParseNumber<int>(*classes);
    if (!number || *number < kMinZones || *number > kMaxZones)
      return BadZones(
          fmt::format("The parameter \"classes\" is a number from {} to {}.", kMinZones, kMaxZones));
    wanted.classes = *number;
  }
  if (const auto resolution = request.Query("resolution_m")) {
    wanted.resolution_m = ParseNumber<double>(*resolution);
    if (!wanted.resolution_m || !(*wanted.resolution_m > 0.0) || !(*wanted.resolution_m < 1e5))
      return BadZones(
          "The parameter \"resolution_m\" is the side of a cell in metres, as in resolution_m=2.");
  }
  const std::string_view format = request.Query("format").value_or("geojson");
  if (format == "shp") {
    wanted.format = storage::OutlineFormat::kShapefile;
  } else if (format != "geojson") {
    return BadZones("The parameter \"format\" is geojson or shp.");
  }
  return wanted;
}

// Cells over the whole map.
Result<storage::MercGrid> GridOfZones(const geo::LatLonBounds& map_bounds,
                                      std::optional<double> resolution_m) {
  geo::LatLonBounds bounds = map_bounds;
  bounds.south_deg = std::max(bounds.south_deg, -85.0);
  bounds.north_deg = std::min(bounds.north_deg, 85.0);
  const geo::Bounds2 merc = geo::MercFromLatLonBounds(bounds);
  const double side_m = std::max(merc.Width(), merc.Height());
  const double ground = geo::GroundMetresPerMercMetre(bounds.Middle().lat_deg);
  const double cell_m = resolution_m ? *resolution_m / ground : side_m / kUsualZoneCells;
  if (!(side_m / cell_m <= kMaxZoneCells))
    return BadZones(
        fmt::format("Cells of that size would be more than {} on a side of this map. Ask for "
                    "resolution_m={:.2g} or more.",
                    kMaxZoneCells, 1.01 * side_m * ground / kMaxZoneCells));
  const auto count = [&](double length_m) {
    return std::max(1, static_cast<int>(std::ceil(length_m / cell_m)));
  };
  return storage::MercGrid{merc.min.x(), merc.max.y(),        cell_m,
                           cell_m,       count(merc.Width()), count(merc.Height())};
}

MapWindow WindowOn(const storage::MercGrid& grid) {
  return {grid.width_px, grid.height_px,
          [=](int column) { return grid.west_m + (column + 0.5) * grid.pixel_width_m; },
          [=](int row) { return grid.north_m - (row + 0.5) * grid.pixel_height_m; }, grid.pixel_width_m};
}

storage::ClassGrid Classified(const IndexValues& values, const storage::MercGrid& grid,
                              const std::vector<double>& breaks) {
  storage::ClassGrid made{grid, std::vector<std::uint8_t>(values.values.size(), 0)};
  for (std::size_t i = 0; i < values.values.size(); ++i) {
    if (values.alphas[i] < kSolidMapAlpha) continue;
    made.classes[i] = static_cast<std::uint8_t>(1 + indices::ClassOf(values.values[i], breaks));
  }
  return made;
}

std::vector<storage::ClassFacts> FactsOfZones(const IndexValues& values, const storage::ClassGrid& grid,
                                              std::size_t classes) {
  std::vector<storage::ClassFacts> facts(classes);
  std::vector<std::int64_t> counts(classes, 0);
  const storage::MercGrid& cells = grid.grid;
  for (int row = 0; row < cells.height_px; ++row) {
    const double lat_deg =
        geo::LatLonFromMerc({0.0, cells.north_m - (row + 0.5) * cells.pixel_height_m}).lat_deg;
    const double cell_m2 = cells.pixel_width_m * cells.pixel_height_m * geo::GroundPerMercArea(lat_deg);
    for (int column = 0; column < cells.width_px; ++column) {
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(cells.width_px) +
                      static_cast<std::size_t>(column);
      if (grid.classes[at] == 0) continue;
      const auto zone = static_cast<std::size_t>(grid.classes[at]) - 1;
      storage::ClassFacts& fact = facts[zone];
      fact.area_m2 += cell_m2;
      const double value = values.values[at];
      if (std::isnan(value)) continue;  // a small hole, which sieving closed
      fact.min = counts[zone] == 0 ? value : std::min(fact.min, value);
      fact.max = counts[zone] == 0 ? value : std::max(fact.max, value);
      fact.mean += value;
      ++counts[zone];
    }
  }
  for (std::size_t zone = 0; zone < classes; ++zone) {
    if (counts[zone] > 0) facts[zone].mean /= static_cast<double>(counts[zone]);
  }
  return facts;
}

// Zones for spreaders and sprayers. Takes up to some seconds.
Result<Response> AnswerZones(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const ZoneRequest wanted, ParseZones(request));
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  SKYQUILT_TRY_ASSIGN(const storage::MercGrid grid,
                      GridOfZones(tileset->revision.bounds, wanted.resolution_m));
  SKYQUILT_TRY_ASSIGN(const IndexValues values,
                      ValuesOfWindow(service.bands, *tileset, wanted.look.expression, WindowOn(grid)));
  std::vector<float> known;
  for (std::size_t i = 0; i < values.values.size(); ++i) {
    if (values.alphas[i] >= kSolidMapAlpha) known.push_back(values.values[i]);
  }
  if (known.empty())
    return Error{ErrorCode::kUnprocessable, "This index has no value anywhere on the map. Choose another."};
  const std::vector<double> breaks = indices::QuantileBreaks(std::move(known), wanted.classes);
  storage::ClassGrid zones = Classified(values, grid, breaks);
  SKYQUILT_TRY(storage::SieveClasses(zones, kMinPatchCells));
  const std::vector<storage::ClassFacts> facts = FactsOfZones(values, zones, breaks.size() + 1);
  SKYQUILT_TRY_ASSIGN(std::string bytes, storage::OutlineClasses(zones, facts, wanted.format));
  const bool is_shapefile = wanted.format == storage::OutlineFormat::kShapefile;
  Response response = Text(200, std::move(bytes), is_shapefile ? "application/zip" : "application/geo+json");
  const std::string name = wanted.look.name.empty() ? "index" : wanted.look.name;
  response.headers.Add("Content-Disposition", fmt::format("attachment; filename=\"zones-{}.{}\"", name,
                                                          is_shapefile ? "zip" : "geojson"));
  return NoCache(std::move(response));
}

using BandsJson = nlohmann::ordered_json;

Result<Response> AnswerBands(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> bands, BandsOf(service.bands, *tileset));
  BandsJson json;
  json["revision"] = tileset->revision.revision;
  json["bands"] = bands;
  json["indices"] = BandsJson::array();
  for (const indices::SpectralIndex* index : indices::IndicesOf(bands)) {
    json["indices"].push_back({{"id", index->name},
                               {"title", index->title},
                               {"expression", index->expression},
                               {"rescale", {index->least, index->most}},
                               {"colormap", index->ramp}});
  }
  json["colormaps"] = BandsJson::array();
  for (const std::string_view name : indices::ColourRamp::Names()) {
    json["colormaps"].push_back({{"id", name}, {"colours", StopsOf(*indices::ColourRamp::Named(name))}});
  }
  return NoCacheJson(json);
}

Result<Response> AnswerLegend(Service& service, const Request& request, LegendFormat format) {
  SKYQUILT_TRY_ASSIGN(const IndexLook look, LookRequiredIn(request));
  SKYQUILT_TRY(CheckId(request.Parameter("flight"), "flight"));
  SKYQUILT_TRY(service.catalogue.GetFlight(request.Parameter("flight")));
  return LegendOf(request, look, format);
}

}  // namespace

void AddIndexRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/bands", On(service, AnswerBands));
  for (const auto& [path, format] : {std::pair{"/api/v1/flights/{flight}/legend.svg", LegendFormat::kSvg},
                                     std::pair{"/api/v1/flights/{flight}/legend.png", LegendFormat::kPng}}) {
    router.Add(Method::kGet, path, [&service, format = format](const Request& request) {
      return AnswerLegend(service, request, format);
    });
  }
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/zones", On(service, AnswerZones));
}

}  // namespace skyquilt::api
