#include "server/sandbox/spawn_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <thread>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "server/sandbox/spawn_self.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kProgramPollInterval{100};
constexpr int kBehindOthers = 10;  // nice

void Limit(pid_t pid, const ProgramToRun& program) {
  const auto set = [&](auto what, std::int64_t most) {
    const rlimit limit{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
    prlimit(pid, what, &limit, nullptr);
  };
  set(RLIMIT_CPU, program.cpu_s);
  set(RLIMIT_FSIZE, program.file_bytes);
  set(RLIMIT_CORE, 0);
  setpriority(PRIO_PGRP, static_cast<id_t>(pid), kBehindOthers);
}

int Collect(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

Result<int> RunProgram(const ProgramToRun& program, const std::function<bool()>& go_on) {
  const FileDescriptor log(open(program.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  if (!log.is_open())
    return Error{ErrorCode::kUnavailable, "A program could not be started. Try again later.",
                 program.log.string()};
  SKYQUILT_TRY_ASSIGN(const pid_t pid,
                      SpawnOther(program.path, program.words, program.environment, log.get()));
  Limit(pid, program);
  const auto end = std::chrono::steady_clock::now() + program.wall;
  const auto stopped = [&](ErrorCode code, std::string message) {
    kill(-pid, SIGKILL);
    Collect(pid);
    return Error{code, std::move(message), program.path};
  };
  while (true) {
    int status = 0;
    const pid_t ended = waitpid(pid, &status, WNOHANG);
    if (ended == pid) {
      kill(-pid, SIGKILL);  // what it left behind
      return status;
    }
    if (ended < 0 && errno != EINTR)
      return stopped(ErrorCode::kUnavailable, "A program was lost. Try again.");
    if (go_on && !go_on()) return stopped(ErrorCode::kCancelled, "This was cancelled.");
    if (std::chrono::steady_clock::now() >= end)
      return stopped(ErrorCode::kTimeout,
                     fmt::format("{} took more than {} minutes.", program.path, program.wall.count() / 60));
    std::this_thread::sleep_for(kProgramPollInterval);
  }
}

}  // namespace skyquilt::server
