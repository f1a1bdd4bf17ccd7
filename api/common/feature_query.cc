#include "api/common/feature_query.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>

#include "core/base/try.h"

namespace skyquilt::api {
namespace {

Error BadQuery(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message), ""}; }

Result<std::optional<Instant>> EndOfSpan(std::string_view text) {
  if (text.empty() || text == "..") return std::optional<Instant>();
  const auto instant = InstantOf(text);
  if (!instant) {
    return BadQuery(
        "\"datetime\" must be a time as 2024-06-01T10:00:00Z, or two with a slash between; \"..\" is an open "
        "end.");
  }
  return instant;
}

}  // namespace

std::vector<std::string_view> PartsOf(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

Result<geo::LatLonBounds> BboxOf(const std::vector<double>& numbers) {
  const Error bad = BadQuery(
      "\"bbox\" must be west,south,east,north in degrees: longitudes from -180 to 180, latitudes from -90 to "
      "90, south not above north.");
  if (numbers.size() != 4 && numbers.size() != 6) return bad;
  const std::size_t half = numbers.size() / 2;
  geo::LatLonBounds box{numbers[0], numbers[1], numbers[half], numbers[half + 1]};
  for (const double lon_deg : {box.west_deg, box.east_deg})
    if (!(std::abs(lon_deg) <= 180.0)) return bad;
  for (const double lat_deg : {box.south_deg, box.north_deg})
    if (!(std::abs(lat_deg) <= 90.0)) return bad;
  if (box.south_deg > box.north_deg) return bad;
  if (box.west_deg > box.east_deg) box.east_deg += 360.0;
  return box;
}

Result<TimeSpan> ParseTimeSpan(std::string_view text) {
  const std::vector<std::string_view> ends = PartsOf(text, '/');
  TimeSpan span;  // one time alone is both its ends
  SKYQUILT_TRY_ASSIGN(span.from, EndOfSpan(ends.front()));
  SKYQUILT_TRY_ASSIGN(span.to, EndOfSpan(ends.back()));
  const bool is_one_time = ends.size() == 1 && span.from;
  const bool is_span =
      ends.size() == 2 && (span.from || span.to) && !(span.from && span.to && *span.from > *span.to);
  if (!is_one_time && !is_span)
    return BadQuery("\"datetime\" must be one time, or two in their order with a slash between.");
  return span;
}

Result<geo::LatLonBounds> ParseBbox(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view part : PartsOf(text.substr(0, 400), ',')) {
    double number = std::nan("");
    const auto parsed = std::from_chars(part.data(), part.data() + part.size(), number);
    if (parsed.ec != std::errc() || parsed.ptr != part.data() + part.size()) number = std::nan("");
    numbers.push_back(number);
  }
  return BboxOf(numbers);
}

std::array<double, 4> GeoJsonBbox(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  if (east - west >= 360.0) return {-180.0, south, 180.0, north};
  return {west, south, east > 180.0 ? east - 360.0 : east, north};
}

bool BoxesMeet(const geo::LatLonBounds& a, const geo::LatLonBounds& b) {
  if (a.south_deg > b.north_deg || a.north_deg < b.south_deg) return false;
  return std::ranges::any_of(std::array{-360.0, 0.0, 360.0}, [&](double turn_deg) {
    return a.west_deg + turn_deg <= b.east_deg && a.east_deg + turn_deg >= b.west_deg;
  });
}

Result<int> ParseLimit(std::string_view text, int otherwise, int most) {
  if (text.empty()) return otherwise;
  std::int64_t limit = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), limit);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || limit < 1)
    return BadQuery("\"limit\" must be a whole number from 1 on.");
  return static_cast<int>(std::min<std::int64_t>(limit, most));
}

}  // namespace skyquilt::api
