#include "server/sandbox/sandboxed_child.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <thread>

#include "server/sandbox/process_limits.h"
#include "server/sandbox/spawn_self.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;

// A child that does not read its messages within this time is stuck.
constexpr std::chrono::seconds kTellPatience{30};
constexpr std::chrono::milliseconds kExitPollInterval{2};
// The parent's own words: a flight of 20 000 files with long names is 6 MiB.
constexpr std::size_t kMaxTaskBytes = std::size_t{256} << 20;

}  // namespace

Result<std::unique_ptr<SandboxedChild>> SandboxedChild::Start(std::vector<std::string> words) {
  const auto no_means = [] {
    return Error{ErrorCode::kUnavailable, "The server could not start a process. Try again later.",
                 std::system_category().message(errno)};
  };
  int to[2];
  int from[2];
  if (pipe2(to, O_CLOEXEC) != 0) return no_means();
  if (pipe2(from, O_CLOEXEC) != 0) {
    const Error error = no_means();
    close(to[0]);
    close(to[1]);
    return error;
  }
  fcntl(to[1], F_SETFL, O_NONBLOCK);
  words.insert(words.end(), {"--parent", std::to_string(getpid())});
  const Result<pid_t> pid = SpawnSelf(std::move(words), Secrets::kWithheld, from[1], to[0]);
  close(to[0]);
  close(from[1]);
  if (!pid) {
    close(to[1]);
    close(from[0]);
    return pid.error();
  }
  return std::unique_ptr<SandboxedChild>(new SandboxedChild(*pid, to[1], from[0]));
}

SandboxedChild::~SandboxedChild() {
  Kill();
  close(to_child_);
  close(from_child_);
}

bool SandboxedChild::Tell(std::string_view message) { return writer_.Write(message, kTellPatience); }

double SandboxedChild::CpuS() const {
  clockid_t clock{};
  timespec used{};
  if (status_ || clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0.0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::int64_t SandboxedChild::MemoryBytes() const {
  if (status_) return 0;
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  std::int64_t size = 0, resident = 0, shared = 0;
  statm >> size >> resident >> shared;
  return (resident - shared) * sysconf(_SC_PAGESIZE);
}

int SandboxedChild::End(std::chrono::milliseconds patience) {
  if (status_) return *status_;
  const auto end = Clock::now() + patience;
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(pid_, &status, WNOHANG);
    if (ended == pid_) break;
    if (ended < 0 && errno != EINTR) break;  // somebody else collected it: it is gone all the same
    if (Clock::now() >= end) {
      kill(pid_, SIGKILL);
      while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
      }
      break;
    }
    std::this_thread::sleep_for(kExitPollInterval);
  }
  status_ = status;
  return status;
}

std::optional<MessageWriter> MeetParent(int parent) {
  if (!FollowParent(parent, SIGKILL)) return std::nullopt;
  const int to_parent = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  if (to_parent < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return std::nullopt;
  return MessageWriter(to_parent);
}

MessageReader ParentsMessages() { return MessageReader(STDIN_FILENO, kMaxTaskBytes); }

}  // namespace skyquilt::server
