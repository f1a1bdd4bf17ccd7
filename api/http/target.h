// ParseTarget: the request target of HTTP, strictly (RFC 3986 path and query of origin form). Every path
// segment is decoded. Segments that could be taken for a path are refused: "..", ".", an empty segment, and
// slash, backslash, NUL or a control character in any encoding; so is invalid UTF-8. Pure.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxTargetBytes = 8192;

struct Target {
  std::vector<std::string> segments;  // "/" has none
  std::vector<std::pair<std::string, std::string>> query;
};

// Errors: kInvalidArgument, with what is wrong.
Result<Target> ParseTarget(std::string_view target);

// What stands behind the "?", or a form of application/x-www-form-urlencoded: decoded, in order.
Result<std::vector<std::pair<std::string, std::string>>> ParseQuery(std::string_view text);

}  // namespace skyquilt::api
