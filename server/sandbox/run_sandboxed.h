// RunSandboxed: decodes files of users in another process of this program, so that a parser exploit or crash
// harms that process alone: its memory and CPU time are limited, its wall time is watched from outside, and
// its output is bounded. The parent calls RunSandboxed; the child is a command that calls AnswerParent.
//
// Blocking; any thread. The kernel ends the child when the thread that called RunSandboxed ends.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "core/base/result.h"

namespace skyquilt::server {

struct SandboxedTask {
  const char* command;  // of this program; for the log, too: "verdict"
  std::string task;     // what it is told
  std::chrono::milliseconds deadline{60'000};
  std::size_t max_answer_bytes = std::size_t{16} << 20;
  std::string refusal;  // the message of the error when it did not live to its end
};

// The child's answer, which is JSON. Errors: those that the child reported; kUnprocessable with the task's
// `refusal` where it died, took too long, said too much or what is no answer; kUnavailable where no process
// could be started or the server stops.
Result<std::string> RunSandboxed(const SandboxedTask& task);

// From now on no task is begun, and those that run are ended within a tenth of a second.
void EndAllSandboxed();

// All that such a child does. `work` calls EnterSandbox before it looks at anything that others made; what it
// answers is JSON without a member "error". The exit code.
int AnswerParent(int parent, const std::function<Result<std::string>(const std::string& task)>& work);

}  // namespace skyquilt::server
