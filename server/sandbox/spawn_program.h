// RunProgram: has one piece of work done by another program of this machine. Nothing of this process goes
// along: no descriptor, no signal that is blocked or ignored, and of the environment what the caller lists.
// It works in a process group of its own, behind everything else, within limits of processor time and of a
// file's size, and is ended, with what it started, when its time is over or nobody wants it. Blocking; any
// thread. Errors: kUnavailable (it could not be started), kTimeout, kCancelled.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

struct ProgramToRun {
  std::string path;
  std::vector<std::string> words;        // behind its name
  std::vector<std::string> environment;  // "HOME=/tmp/x"
  std::filesystem::path log;             // what it says on standard error
  std::chrono::seconds wall{120};
  std::int64_t cpu_s = 240;
  std::int64_t file_bytes = std::int64_t{1} << 30;
};

// Its wait status. `go_on`: asked some times a second; absent: always.
Result<int> RunProgram(const ProgramToRun& program, const std::function<bool()>& go_on);

}  // namespace skyquilt::server
