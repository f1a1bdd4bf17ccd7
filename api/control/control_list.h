// ControlListText: the surveyed points of a flight and where they were marked in its photos, from the API's
// JSON to the list that the stitcher reads (core/flight/logs/texts/gcp_list.h; the way back is
// core/pipeline/placing/control_points.h). Pixels of the JSON count from the middle of the first one, as
// everywhere in the API; those of the list from its corner. Pure; any thread. Errors, whole sentences for the
// user: kTooLarge, kInvalidArgument (no JSON), kUnprocessable (a field that breaks its rule).
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxControlBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxControlPoints = 2000;
inline constexpr std::size_t kMaxControlMarks = 10'000;

// Of a flight that has none.
std::string NoControlJson();

// The list of what the JSON says; empty where it has no points. Whether the reference system is known and the
// points lie in its area shows when the list is read.
Result<std::string> ControlListText(std::string_view json);

}  // namespace skyquilt::api
