#include "server/imports/told_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text/json_io.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::server {
namespace {

using ToldReport = nlohmann::json;

constexpr std::array<std::string_view, 8> kReadFields = {"bounds",     "min_zoom", "max_zoom", "tile_size_px",
                                                         "tile_count", "quality",  "gsd_m",    "area_m2"};
// Of these fields; a report of ours has a hundredth of it.
constexpr int kMaxReportDepth = 8, kMaxReportValues = 10'000;
constexpr double kSameTilesDeg = 1e-9;
constexpr double kSameRasterPx = 2.0;
constexpr double kMetresPerDeg = 111'320.0;

bool HasBounds(const ToldReport& told, const pipeline::MosaicReport& imported, bool is_of_tiles) {
  const std::vector<double> bounds = told.at("bounds").get<std::vector<double>>();
  const auto wanted = imported.bounds.ToArray();
  if (bounds.size() != wanted.size()) return false;
  const double lat_rad = geo::DegToRad(imported.bounds.Middle().lat_deg);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const double metres_per_deg = i % 2 == 0 ? kMetresPerDeg * std::cos(lat_rad) : kMetresPerDeg;
    const double apart_deg = is_of_tiles ? kSameTilesDeg : kSameRasterPx * imported.gsd_m / metres_per_deg;
    if (!(std::abs(bounds[i] - wanted[i]) <= apart_deg)) return false;
  }
  return true;
}

bool HasTiles(const ToldReport& told, const pipeline::MosaicReport& imported) {
  return told.at("min_zoom") == imported.min_zoom && told.at("max_zoom") == imported.max_zoom &&
         told.at("tile_size_px") == imported.tile_size_px && told.at("tile_count") == imported.tile_count;
}

// Of a text of any size what is read of a report, with no more memory than that takes. Throws as parse does.
ToldReport ReadFieldsOf(std::string_view json) {
  bool is_read = true, is_beyond = false;
  int values = 0;
  const auto keep = [&](int depth, ToldReport::parse_event_t event, const ToldReport& parsed) {
    using Event = ToldReport::parse_event_t;
    if (event == Event::key && depth == 1)
      is_read = std::find(kReadFields.begin(), kReadFields.end(), parsed.get_ref<const std::string&>()) !=
                kReadFields.end();
    if (event == Event::key) return is_read;
    if (event == Event::object_end || event == Event::array_end || depth == 0) return true;
    is_beyond |= is_read && (depth > kMaxReportDepth || ++values > kMaxReportValues);
    return is_read && !is_beyond;
  };
  ToldReport report = ToldReport::parse(json.begin(), json.end(), keep);
  return is_beyond ? ToldReport() : report;
}

// Tiles are taken over as they are, and with them what their report says of the map's resolution and area:
// pixels of tiles may be finer, and tiles reach beyond it.
bool SaysSoOfTiles(const Told& told, const pipeline::MosaicReport& imported) {
  constexpr double kSlack = 1.001, kMaxTimes = 100.0;
  return told.gsd_m * kSlack >= imported.gsd_m && told.gsd_m <= kMaxTimes * imported.gsd_m &&
         told.area_m2 > 0.0 && told.area_m2 <= kSlack * imported.area_m2;
}

}  // namespace

std::optional<Told> ToldOfMap(std::string_view report_json, const pipeline::MosaicReport& imported,
                              bool is_of_tiles) {
  try {
    const ToldReport report = ReadFieldsOf(report_json);
    if (!HasBounds(report, imported, is_of_tiles) || (is_of_tiles && !HasTiles(report, imported)))
      return std::nullopt;
    Result<pipeline::MapQuality> quality = pipeline::ParseQuality(JsonText(report.at("quality")));
    if (!quality) return std::nullopt;
    Told told{*std::move(quality), imported.gsd_m, imported.area_m2};
    if (!is_of_tiles) return told;
    told.gsd_m = report.at("gsd_m").get<double>();
    told.area_m2 = report.at("area_m2").get<double>();
    return SaysSoOfTiles(told, imported) ? std::optional(std::move(told)) : std::nullopt;
  } catch (const ToldReport::exception&) {
    return std::nullopt;  // of a program that calls its report the same
  }
}

bool IsReportOfAMap(std::string_view report_json) {
  try {
    return pipeline::ParseQuality(JsonText(ReadFieldsOf(report_json).at("quality"))).ok();
  } catch (const ToldReport::exception&) {
    return false;
  }
}

}  // namespace skyquilt::server
