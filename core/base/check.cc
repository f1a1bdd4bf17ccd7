#include "core/base/check.h"

#include <cstdio>
#include <cstdlib>

namespace skyquilt::internal {

void CheckFailed(const char* condition, const char* file, int line, std::string_view message) {
  std::fprintf(stderr, "skyquilt: internal error: %s:%d: %s: %.*s\n", file, line, condition,
               static_cast<int>(message.size()), message.data());
  std::fflush(stderr);
  std::abort();
}

}  // namespace skyquilt::internal
