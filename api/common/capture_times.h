// UtcOfCapture: the UTC of a time that a photo records. Cameras without a zone write the clock on the wall:
// then the zone is that of the place's longitude, a quarter of an hour of the sun's time each 3.75 degrees,
// to a whole hour; laws and summer time put clocks up to two hours beside it. InstantOf: a time of RFC 3339.
// Pure; any thread. Nothing of a text that is no time.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::api {

// "2024-06-01T10:00:00.5" (at 30 degrees east), "2024-06-01T10:00:00.5+02:00" and
// "2024-06-01T08:00:00.5Z" alike: "2024-06-01T08:00:00.5Z".
std::optional<std::string> UtcOfCapture(std::string_view recorded, double lon_deg);

// "2024-06-01T10:00:00Z", "2024-06-01t10:00:00.25+02:00": to the microsecond, whatever follows it.
using Instant = std::chrono::sys_time<std::chrono::microseconds>;
std::optional<Instant> InstantOf(std::string_view text);

}  // namespace skyquilt::api
