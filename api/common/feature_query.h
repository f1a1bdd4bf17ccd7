// What OGC API Features and STAC ask lists by: a box, a time and how many. Values; any thread. Errors:
// kInvalidArgument, with the parameter and what to write instead.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "api/common/capture_times.h"
#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::api {

// From one time to another, both included; absent: without an end.
struct TimeSpan {
  std::optional<Instant> from, to;
};
// "2024-06-01T10:00:00Z", "2024-06-01T00:00:00Z/..": as OGC API and STAC write them.
Result<TimeSpan> ParseTimeSpan(std::string_view text);

// "7.1,46.8,7.2,46.9", or six numbers with heights between, which are passed over. A box whose west is
// beyond its east goes across the antimeridian: its east is beyond 180 then.
Result<geo::LatLonBounds> ParseBbox(std::string_view text);
Result<geo::LatLonBounds> BboxOf(const std::vector<double>& numbers);
// The way back: across the antimeridian the east is west of the west (RFC 7946, section 5.2).
std::array<double, 4> GeoJsonBbox(const geo::LatLonBounds& bounds);
bool BoxesMeet(const geo::LatLonBounds& a, const geo::LatLonBounds& b);

// 1 and more; what is above `most` means as many as there may be.
Result<int> ParseLimit(std::string_view text, int otherwise, int most);

std::vector<std::string_view> PartsOf(std::string_view text, char separator);

}  // namespace skyquilt::api
