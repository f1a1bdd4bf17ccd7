// Other processes: SpawnSelf starts one of this binary, RunProgram has a piece of work done by another
// program. No signal is blocked or ignored there, whatever this process does with its own, and none of its
// descriptors goes along but what is named here. Any thread; but the kernel signals a child when the thread
// that started it ends.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

// What of the environment goes along: all, or what is known to be harmless. Keys of stores and databases,
// tokens and the like are for who speaks to others: whoever decodes the files of others could write them into
// what it makes.
enum class Secrets { kKept, kWithheld };

// `words`: what follows the program's name; "--parent" and the number of this process are added. `stdout_fd`,
// `stdin_fd`: what its standard output and input become, where given. Error: kUnavailable.
Result<pid_t> SpawnSelf(std::vector<std::string> words, Secrets secrets,
                        std::optional<int> stdout_fd = std::nullopt,
                        std::optional<int> stdin_fd = std::nullopt);

struct ProcessEnd {
  int wait_status = 0;  // as waitpid has it
  rusage used{};
};
// Waits for the end of a process that this one started, for `patience` at most and while `go_on` (absent:
// always) says so, then kills it.
ProcessEnd WaitOrKill(pid_t pid, std::chrono::milliseconds patience,
                      const std::function<bool()>& go_on = nullptr);

// "by signal 9 (Killed)", "with code 1": of a status that waitpid gave.
std::string HowItEnded(int wait_status);

struct ProgramToRun {
  std::string path;
  std::vector<std::string> words;        // behind its name
  std::vector<std::string> environment;  // "HOME=/tmp/x"
  std::filesystem::path log;             // what it says on standard error
  std::chrono::seconds wall{120};
  std::int64_t cpu_s = 240;
  std::int64_t file_bytes = std::int64_t{1} << 30;
};

// Has its environment from the caller alone, nothing to read and nowhere to write to but the log. It works in
// a process group of its own, behind everything else, within its limits, and is ended, with what it started,
// when its time is over or nobody wants it. Blocking. Its wait status. `go_on`: asked some times a second;
// absent: always. Errors: kUnavailable (it could not be started), kOutOfSpace and kIo (the log), kTimeout,
// kCancelled.
Result<int> RunProgram(const ProgramToRun& program, const std::function<bool()>& go_on);

}  // namespace skyquilt::server
