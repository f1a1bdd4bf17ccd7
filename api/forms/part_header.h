// ParsePartHeader: the header block of one part of multipart/form-data. Pure. Errors: kInvalidArgument.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "api/forms/multipart.h"

namespace skyquilt::api {

// `block` is the lines between the delimiter and the empty line, each ended by CR LF but the last.
Result<PartHeader> ParsePartHeader(std::string_view block);

// "form-data; name=\"a\"; filename=\"b\"" -> the value in lower case and its parameters (names in lower
// case).
struct HeaderValue {
  std::string value;
  std::vector<std::pair<std::string, std::string>> parameters;
};
Result<HeaderValue> ParseHeaderValue(std::string_view text);

}  // namespace skyquilt::api
