// What a map shows within a polygon: its area, how much of it the map covers, and of each colour the least,
// the greatest, the mean, the spread and a histogram; the same of an index, with percentiles. Of the finest
// zoom at which the polygon has at most kMaxPixels pixels; the answer says which. Any thread; takes up to
// half a second, with a slow expression up to three. Errors: kInvalidArgument, kUnprocessable (no polygon),
// kNotFound (no such flight, or no map yet), kCorrupt, kIo.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/common/index_look.h"
#include "api/service.h"

namespace skyquilt::api {

inline constexpr double kMaxPixels = 8 << 20;
inline constexpr double kMinPixels = 1024;

// `polygon`: GeoJSON (storage/exports/custom/boundary). JSON text.
Result<std::string> MapStatistics(Service& service, const std::string& flight_id, std::string_view polygon,
                                  const std::optional<IndexLook>& look = std::nullopt,
                                  double max_pixels = kMaxPixels);

}  // namespace skyquilt::api
