// ComparisonPng: the maps of several methods side by side: above, the whole flight; below, the middle of the
// map, pixel by pixel. The same ground at the same scale in each. Methods without a map are left out.
// Blocking. Errors: kUnprocessable (no method made a map), those of reading the maps.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/comparison/compare_methods.h"

namespace skyquilt::server {

Result<std::string> ComparisonPng(const std::vector<MethodOutcome>& outcomes);

}  // namespace skyquilt::server
