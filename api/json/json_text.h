// CheckJsonText: cheap limits before a JSON text is parsed: at most so many bytes and 32 levels, so that no
// client can make the parser recurse or the document grow. Pure.
#pragma once

#include <string_view>

#include "core/base/result.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxJsonBytes = 64 * 1024;
inline constexpr int kMaxJsonDepth = 32;

Result<void> CheckJsonText(std::string_view text, std::size_t max_bytes = kMaxJsonBytes);

}  // namespace skyquilt::api
