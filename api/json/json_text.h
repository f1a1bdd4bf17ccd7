// CheckJsonText: cheap limits before a JSON text is parsed: at most so many bytes, 32 levels and 1,000
// members of an object, so that no client can make the parser recurse or the document grow, nor have each
// member looked for among a hundred thousand, which is what keeping their order costs. Pure.
#pragma once

#include <string_view>

#include "core/base/result.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxJsonBytes = 64 * 1024;
inline constexpr int kMaxJsonDepth = 32;
inline constexpr int kMaxJsonMembers = 1000;

Result<void> CheckJsonText(std::string_view text, std::size_t max_bytes = kMaxJsonBytes);

}  // namespace skyquilt::api
