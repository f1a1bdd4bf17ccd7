// What WMS and WMTS answer to GetFeatureInfo: what maps show at a place, as GeoJSON, text or a table of HTML.
// Pure.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "api/flights/point.h"

namespace skyquilt::api {

inline constexpr std::array<const char*, 4> kInfoFormats = {"application/json", "application/geo+json",
                                                            "text/plain", "text/html"};
bool IsInfoFormat(std::string_view type);
// Precondition: the type is one of them.
Response InfoResponse(const std::vector<MapPoint>& points, std::string_view type);

}  // namespace skyquilt::api
