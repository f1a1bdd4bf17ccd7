// MachineBoot: the current boot of the machine and the time since then, sleep included. Independent of the
// wall clock. Any thread.
#pragma once

#include <chrono>
#include <string>

namespace skyquilt::storage {

struct MachineBoot {
  // The kernel's; the same for all processes until the machine starts again. Where the kernel tells none, one
  // of this process's own: every start of it then counts as one of the machine.
  static const std::string& Id();
  static std::chrono::microseconds Elapsed();
  // The machine's name on the network, of [A-Za-z0-9._] alone.
  static const std::string& HostName();
};

}  // namespace skyquilt::storage
