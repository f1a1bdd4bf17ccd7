#include "server/imports/told_quality.h"

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/geo/lat_lon.h"

namespace skyquilt::server {
namespace {

using ToldReport = nlohmann::json;

constexpr int kMaxReportDepth = 32;
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

// What is nested deeper than any report takes as much stack when it is written again.
bool IsShallow(std::string_view json) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t at = 0; at < json.size(); ++at) {
    const char c = json[at];
    if (in_text && c == '\\') {
      ++at;
    } else if (c == '"') {
      in_text = !in_text;
    } else if (!in_text && (c == '[' || c == '{')) {
      if (++depth > kMaxReportDepth) return false;
    } else if (!in_text && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return true;
}

}  // namespace

std::optional<pipeline::MapQuality> ToldQuality(std::string_view report_json,
                                                const pipeline::MosaicReport& imported, bool is_of_tiles) {
  if (!IsShallow(report_json)) return std::nullopt;
  try {
    const ToldReport told = ToldReport::parse(report_json);
    if (!HasBounds(told, imported, is_of_tiles) || (is_of_tiles && !HasTiles(told, imported)))
      return std::nullopt;
    const Result<pipeline::MapQuality> quality = pipeline::ParseQuality(told.at("quality").dump());
    return quality ? std::optional(*quality) : std::nullopt;
  } catch (const ToldReport::exception&) {
    return std::nullopt;  // of a program that calls its report the same
  }
}

}  // namespace skyquilt::server
