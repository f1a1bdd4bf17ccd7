// MachineBoot: which run of the machine this is, and for how long it has been going, sleep included. Not
// moved by anyone who sets the clock. Any thread.
#pragma once

#include <chrono>
#include <string>

namespace skyquilt::storage {

struct MachineBoot {
  // The kernel's; the same for all processes until the machine starts again. Where the kernel tells none, one
  // of this process's own: every start of it then counts as one of the machine.
  static const std::string& Id();
  static std::chrono::microseconds Elapsed();
};

}  // namespace skyquilt::storage
