#include "server/sandbox/sandboxed_child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <limits>
#include <system_error>
#include <thread>

#include "server/sandbox/sandbox.h"
#include "server/sandbox/spawn_process.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kHeadBytes = 4;

// Whether something happens on the descriptor before `end`.
bool Wait(int fd, short events, Clock::time_point end) {
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd wanted{fd, events, 0};
    const int most = std::numeric_limits<int>::max();
    const int happened = poll(&wanted, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, most)));
    if (happened > 0) return true;
    if (happened == 0 || errno != EINTR) return false;
  }
}

}  // namespace

bool MessageWriter::Write(std::string_view message, std::chrono::milliseconds patience) {
  const auto end = Clock::now() + patience;
  std::string bytes;
  bytes.reserve(kHeadBytes + message.size());
  for (std::size_t i = 0; i < kHeadBytes; ++i)
    bytes.push_back(static_cast<char>((message.size() >> (8 * i)) & 0xff));
  bytes.append(message);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = write(fd_, bytes.data() + done, bytes.size() - done);
    if (wrote > 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno == EAGAIN) {
      if (!Wait(fd_, POLLOUT, end)) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

std::optional<std::string> MessageReader::Next() {
  if (unread_.size() < kHeadBytes) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < kHeadBytes; ++i)
    length |= static_cast<std::size_t>(static_cast<unsigned char>(unread_[i])) << (8 * i);
  if (length > max_bytes_) {
    is_ended_ = true;
    return std::nullopt;
  }
  if (unread_.size() < kHeadBytes + length) return std::nullopt;
  std::string message = unread_.substr(kHeadBytes, length);
  unread_.erase(0, kHeadBytes + length);
  return message;
}

std::optional<std::string> MessageReader::Read(std::chrono::milliseconds patience) {
  const auto end = Clock::now() + patience;
  while (!is_ended_) {
    if (auto message = Next()) return message;
    if (is_ended_ || !Wait(fd_, POLLIN, end)) break;
    char block[16 * 1024];
    const ssize_t got = read(fd_, block, sizeof(block));
    if (got > 0) {
      unread_.append(block, static_cast<std::size_t>(got));
    } else if (got == 0 || (errno != EINTR && errno != EAGAIN)) {
      is_ended_ = true;
    }
  }
  return std::nullopt;
}

namespace {

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
