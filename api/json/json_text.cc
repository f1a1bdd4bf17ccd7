#include "api/json/json_text.h"

#include <fmt/format.h>

#include <array>

namespace skyquilt::api {

Result<void> CheckJsonText(std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes)
    return Error{ErrorCode::kTooLarge, fmt::format("The JSON body is longer than {} KiB.", max_bytes >> 10)};
  int depth = 0;
  std::array<int, kMaxJsonDepth + 1> members{};  // of what is open, by its depth
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth)
        return Error{ErrorCode::kInvalidArgument, "The JSON body is nested too deep."};
      if (depth > 0) members[static_cast<std::size_t>(depth)] = 0;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == ':' && depth > 0 && ++members[static_cast<std::size_t>(depth)] > kMaxJsonMembers) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("An object of the JSON body has more than {} members.", kMaxJsonMembers)};
    }
  }
  return {};
}

}  // namespace skyquilt::api
