// RunSandboxed: decodes files of users in another process of this program, so that a parser exploit or crash
// harms that process alone: its memory and CPU time are limited, its wall time is watched from outside, and
// its output is bounded. The parent calls RunSandboxed; the child calls BecomeSandboxed, does the work, then
// TellParent.
//
// Blocking; any thread. The kernel ends the child when the thread that called RunSandboxed ends.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {

struct SandboxedTask {
  std::string name;                // for the log: "verdict"
  std::vector<std::string> words;  // what follows the program's name; "--parent" with this process is added
  std::string input = {};          // its standard input
  std::chrono::milliseconds deadline{60'000};
  std::size_t max_answer_bytes = std::size_t{16} << 20;
  std::string refusal;  // the message of the error when it did not live to its end
};

// The child's answer. Errors: those that the child reported; kUnprocessable with the task's `refusal` where
// it died, took too long or said too much; kUnavailable where no process could be started or the server
// stops.
Result<std::string> RunSandboxed(const SandboxedTask& task);

// From now on no task is begun, and those that run are ended within a tenth of a second.
void EndAllSandboxed();

// The first thing a child does, before it has threads and before it looks at anything that others made:
// EnterSandbox, or the end of it.
void BecomeSandboxed(SandboxNeeds needs);

// All of the standard input.
std::string ReadInput();

// The last thing it does.
void TellParent(const Result<std::string>& answer);

}  // namespace skyquilt::server
