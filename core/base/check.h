// SKYQUILT_CHECK: our own bugs stop loudly. Prints the condition and the place to stderr, then aborts.
// Never for what a user or a file caused (that is an Error). Any thread.
#pragma once

#include <string_view>

namespace skyquilt::internal {
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line, std::string_view message);
}

#define SKYQUILT_CHECK(condition, message)                                                        \
  do {                                                                                            \
    if (!(condition)) ::skyquilt::internal::CheckFailed(#condition, __FILE__, __LINE__, message); \
  } while (false)
