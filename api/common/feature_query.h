// What OGC API Features and STAC ask lists by: a box, a time and how many. Values; any thread. Errors:
// kInvalidArgument, with the parameter and what to write instead.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::api {

// The UTC of a time that a photo records. Cameras without a zone write the clock on the wall: then the zone
// is that of the place's longitude, a quarter of an hour of the sun's time each 3.75 degrees, to a whole
// hour; laws and summer time put clocks up to two hours beside it. Absent: the text is no time.
// "2024-06-01T10:00:00.5" (at 30 degrees east), "2024-06-01T10:00:00.5+02:00" and
// "2024-06-01T08:00:00.5Z" alike: "2024-06-01T08:00:00.5Z".
std::optional<std::string> UtcOfCapture(std::string_view recorded, double lon_deg);

// A time of RFC 3339, "2024-06-01T10:00:00Z", "2024-06-01t10:00:00.25+02:00": to the microsecond, whatever
// follows it.
using Instant = std::chrono::sys_time<std::chrono::microseconds>;
std::optional<Instant> InstantOf(std::string_view text);

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

}  // namespace skyquilt::api
