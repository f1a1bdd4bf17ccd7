#include "server/sandbox/sandboxed_child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/remark_json.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

constexpr std::size_t kHeadBytes = 4;
constexpr std::size_t kMaxErrorBytes = 4 * 1024;  // of an error's message, and of its detail
constexpr std::size_t kMaxReasonBytes = 16 * 1024;
// A byte that is no UTF-8 is sent as the three of the replacement character.
constexpr std::size_t kMaxGrowth = 3;
// A child that does not read its messages within this time is stuck.
constexpr std::chrono::seconds kTellPatience{30};
constexpr std::chrono::milliseconds kAskInterval{50};  // whether it is still wanted
constexpr std::chrono::seconds kEndPatience{10};
constexpr std::chrono::minutes kTaskPatience{1};
// The parent's own words: a flight of 20 000 files with long names is 6 MiB.
constexpr std::size_t kMaxTaskBytes = std::size_t{256} << 20;

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

bool MessageWriter::Write(std::string_view message, std::chrono::milliseconds patience,
                          const std::function<bool()>& go_on) {
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
      const Clock::time_point now = Clock::now();
      if (now >= end || (go_on && !go_on())) return false;
      Wait(fd_, POLLOUT, std::min(end, now + kAskInterval));
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
    is_ended_ = is_too_long_ = true;
    return std::nullopt;
  }
  if (unread_.size() < kHeadBytes + length) return std::nullopt;
  std::string message = unread_.substr(kHeadBytes, length);
  unread_.erase(0, kHeadBytes + length);
  return message;
}

std::optional<std::string> MessageReader::Read(std::chrono::milliseconds patience) {
  const auto end = Clock::now() + patience;
  for (bool is_late = false;;) {
    if (auto message = Next()) return message;
    if (is_ended_ || is_late || !Wait(fd_, POLLIN, end)) return std::nullopt;
    is_late = Clock::now() >= end;
    char block[16 * 1024];
    const ssize_t got = read(fd_, block, sizeof(block));
    if (got > 0) {
      unread_.append(block, static_cast<std::size_t>(got));
    } else if (got == 0 || (errno != EINTR && errno != EAGAIN)) {
      is_ended_ = true;
    }
  }
}

Json ErrorJson(const Error& error) {
  Json json = {{"code", static_cast<int>(error.code)},
               {"message", CutToBytes(error.message, kMaxErrorBytes)},
               {"detail", CutToBytes(error.detail, kMaxErrorBytes)}};
  if (error.reason != nullptr) {
    Json reason = flight::JsonOfRemark<Json>(*error.reason);
    if (JsonText(reason).size() <= kMaxReasonBytes) json["reason"] = std::move(reason);
  }
  return json;
}

std::optional<Error> ErrorOfJson(const Json& json) {
  try {
    const auto code = std::find_if(kAllErrorCodes.begin(), kAllErrorCodes.end(),
                                   [&](ErrorCode one) { return json.at("code") == static_cast<int>(one); });
    if (code == kAllErrorCodes.end()) return std::nullopt;
    Error error{*code, json.at("message"), json.at("detail")};
    if (!IsShort(error.message, kMaxErrorBytes) || !IsShort(error.detail, kMaxErrorBytes))
      return std::nullopt;
    if (json.contains("reason")) {
      flight::Remark reason = flight::RemarkOfJson(json.at("reason"));
      // Of what is a remark: arrays in arrays without end are more than the serializer's stack holds.
      if (JsonText(flight::JsonOfRemark<Json>(reason)).size() > kMaxReasonBytes) return std::nullopt;
      error.reason = std::make_shared<const flight::Remark>(std::move(reason));
    }
    return error;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

bool IsShort(std::string_view text, std::size_t max_bytes) { return text.size() <= kMaxGrowth * max_bytes; }

Result<std::unique_ptr<SandboxedChild>> SandboxedChild::Start(const char* command, std::string_view task,
                                                              std::function<bool()> go_on,
                                                              std::size_t max_message_bytes) {
  const auto no_means = [] {
    return Error{ErrorCode::kUnavailable, "The server could not start a process. Try again later.",
                 std::system_category().message(errno)};
  };
  int to[2];
  int from[2];
  if (pipe2(to, O_CLOEXEC) != 0) return no_means();
  FileDescriptor its_input(to[0]), to_child(to[1]);
  if (pipe2(from, O_CLOEXEC) != 0) return no_means();
  FileDescriptor from_child(from[0]), its_output(from[1]);
  // The child can open its end of a pipe for the other direction, too: what poll() saw may be gone.
  for (const FileDescriptor* own : {&to_child, &from_child}) fcntl(own->get(), F_SETFL, O_NONBLOCK);
  SKYQUILT_TRY_ASSIGN(const pid_t pid,
                      SpawnSelf({command}, Secrets::kWithheld, its_output.get(), its_input.get()));
  // Held here too, they would hide that the child is gone.
  its_input.Close();
  its_output.Close();
  Result<std::unique_ptr<SandboxedChild>> child = std::unique_ptr<SandboxedChild>(new SandboxedChild(
      pid, std::move(to_child), std::move(from_child), std::move(go_on), max_message_bytes));
  (*child)->Tell(task);
  return child;
}

bool SandboxedChild::Tell(std::string_view message) { return writer_.Write(message, kTellPatience, go_on_); }

double SandboxedChild::CpuS() const {
  clockid_t clock{};
  timespec used{};
  if (end_ || clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0.0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::int64_t SandboxedChild::MemoryBytes() const {
  if (end_) return 0;
  std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
  std::int64_t size = 0, resident = 0, shared = 0;
  statm >> size >> resident >> shared;
  return (resident - shared) * sysconf(_SC_PAGESIZE);
}

const ProcessEnd& SandboxedChild::End() {
  // Who says too much waits for somebody to read it.
  if (!end_) end_ = WaitOrKill(pid_, has_said_too_much() ? std::chrono::seconds(0) : kEndPatience, go_on_);
  return *end_;
}

const ProcessEnd& SandboxedChild::Kill() {
  if (!end_) end_ = WaitOrKill(pid_, std::chrono::seconds(0));
  return *end_;
}

int WorkForParent(int parent, const std::function<int(const std::string& task, MessageReader& from_parent,
                                                      MessageWriter& to_parent)>& work) {
  if (!FollowParent(parent, SIGKILL)) return 1;
  // A Ctrl-C in a terminal goes to every process there; when this one is to end, its parent says.
  for (const int number : {SIGINT, SIGHUP}) signal(number, SIG_IGN);
  const int fd = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  if (fd < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return 1;
  MessageWriter to_parent(fd);
  MessageReader from_parent(STDIN_FILENO, kMaxTaskBytes);
  const std::optional<std::string> task = from_parent.Read(kTaskPatience);
  return task ? work(*task, from_parent, to_parent) : 1;
}

}  // namespace skyquilt::server
