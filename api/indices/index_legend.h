// The legend of an index: its ramp from the least value to the greatest, with values below, as SVG or PNG. On
// white, so that it is read on light and on dark. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/common/index_look.h"
#include "api/http/http_message.h"
#include "core/indices/colour_ramp.h"

namespace skyquilt::api {

inline constexpr int kLegendWidthPx = 320, kLegendHeightPx = 64;

enum class LegendFormat { kSvg, kPng };
// "image/png", "image/svg+xml"; nothing: another one.
std::optional<LegendFormat> LegendFormatOf(std::string_view content_type);

// With a tag of its own, good for an hour.
Response LegendOf(const Request& request, const IndexLook& look, LegendFormat format);
// Address of the legend of a named index in its usual colours, as PNG.
std::string LegendPath(std::string_view flight_id, std::string_view index);

// Colours of a ramp, evenly, for who draws it: "#a50026".
std::vector<std::string> StopsOf(const indices::ColourRamp& ramp);

}  // namespace skyquilt::api
