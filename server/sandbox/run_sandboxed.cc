#include "server/sandbox/run_sandboxed.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "server/routing/request_log.h"
#include "server/sandbox/spawn_process.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

constexpr std::chrono::milliseconds kStopPollInterval{100};  // how soon a stopping server is noticed
constexpr std::chrono::milliseconds kUntilGone{5};           // between two checks whether a process has ended
constexpr char kGood = '+';
constexpr char kBad = '-';

std::atomic<bool> is_ending{false};

Error NoMeans() {
  return {ErrorCode::kUnavailable, "The server has no means left for this. Try again later.",
          std::system_category().message(errno)};
}

bool WriteAll(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t wrote = write(fd, text.data(), text.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(wrote));
  }
  return true;
}

// A file in memory, read from its start: unlike a pipe it never makes the writer wait for the reader.
int FileOf(std::string_view text) {
  const int fd = memfd_create("input", MFD_CLOEXEC);
  if (fd < 0) return -1;
  if (WriteAll(fd, text) && lseek(fd, 0, SEEK_SET) == 0) return fd;
  close(fd);
  return -1;
}

struct Heard {
  std::string text;
  std::string why_not;  // empty: it came to its end by itself
  bool is_stopped = false;
};

// Until the child closes its end, says too much, or its time is over.
Heard Listen(int fd, const SandboxedTask& task, Clock::time_point end) {
  Heard heard;
  char block[64 * 1024];
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) {
      heard.why_not = "it took too long";
      return heard;
    }
    if (is_ending) {
      heard.is_stopped = true;
      return heard;
    }
    pollfd ready{fd, POLLIN, 0};
    const int polled = poll(&ready, 1, static_cast<int>(std::min(left, kStopPollInterval).count()) + 1);
    if (polled == 0 || (polled < 0 && errno == EINTR)) continue;
    const ssize_t got = read(fd, block, sizeof(block));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return heard;
    heard.text.append(block, static_cast<std::size_t>(got));
    if (heard.text.size() > task.max_answer_bytes) {
      heard.why_not = "it said too much";
      return heard;
    }
  }
}

struct Ended {
  int status = 0;
  rusage used{};
};

// The child is waited for until `end`, then killed. A dead one is collected at once.
Ended Collect(pid_t child, Clock::time_point end) {
  Ended ended;
  while (true) {
    const pid_t got = wait4(child, &ended.status, WNOHANG, &ended.used);
    if (got == child) return ended;
    if (got < 0 && errno != EINTR) return ended;
    if (is_ending || Clock::now() >= end) break;
    std::this_thread::sleep_for(kUntilGone);
  }
  kill(child, SIGKILL);
  while (wait4(child, &ended.status, 0, &ended.used) < 0 && errno == EINTR) {
  }
  return ended;
}

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// What came over the pipe is what a process said that may have been taken over: nothing of it is believed.
Result<std::string> Understand(std::string text, const std::string& refusal) {
  const Error nonsense{ErrorCode::kUnprocessable, refusal, "its answer cannot be read"};
  if (text.empty() || (text[0] != kGood && text[0] != kBad)) return nonsense;
  const bool is_good = text[0] == kGood;
  text.erase(0, 1);
  if (is_good) return text;
  const Json answer = ParseJson(text);
  if (!answer.is_object()) return nonsense;
  const std::string name = answer.value("code", "");
  const auto code = std::find_if(kAllErrorCodes.begin(), kAllErrorCodes.end(),
                                 [&](ErrorCode each) { return ErrorCodeName(each) == name; });
  if (code == kAllErrorCodes.end()) return nonsense;
  return Error{*code, answer.value("message", refusal), answer.value("detail", "")};
}

}  // namespace

Result<std::string> RunSandboxed(const SandboxedTask& task) {
  const Error stopping{ErrorCode::kUnavailable, "The server is stopping. Try again later.", task.name};
  if (is_ending) return stopping;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return NoMeans();
  const FileDescriptor ours(ends[0]);
  FileDescriptor theirs(ends[1]);
  const FileDescriptor input(FileOf(task.input));
  if (input.get() < 0) return NoMeans();
  std::vector<std::string> words = task.words;
  words.insert(words.end(), {"--parent", std::to_string(getpid())});
  const Clock::time_point begun = Clock::now();
  SKYQUILT_TRY_ASSIGN(const pid_t child,
                      SpawnSelf(std::move(words), Secrets::kWithheld, theirs.get(), input.get()));
  theirs.Close();
  const Clock::time_point end = begun + task.deadline;
  Heard heard = Listen(ours.get(), task, end);
  const bool is_over = heard.is_stopped || !heard.why_not.empty();
  const Ended ended = Collect(child, is_over ? Clock::now() : end);
  const bool is_well = !is_over && WIFEXITED(ended.status) && WEXITSTATUS(ended.status) == 0;
  const std::string how = is_well ? "well" : heard.why_not.empty() ? HowItEnded(ended.status) : heard.why_not;
  LogEvent(fmt::format("{} apart: {:.2f} s, {:.2f} s of CPU, {} MiB, ended {}", task.name,
                       std::chrono::duration<double>(Clock::now() - begun).count(),
                       SecondsOf(ended.used.ru_utime) + SecondsOf(ended.used.ru_stime),
                       ended.used.ru_maxrss >> 10, how));
  if (heard.is_stopped) return stopping;
  if (!is_well) return Error{ErrorCode::kUnprocessable, task.refusal, "it ended: " + how};
  return Understand(std::move(heard.text), task.refusal);
}

void EndAllSandboxed() { is_ending = true; }

void BecomeSandboxed(SandboxNeeds needs) {
  StepBack();
  const Result<void> confined = EnterSandbox(std::move(needs));
  if (confined) return;
  TellParent(confined.error());
  _exit(0);
}

std::string ReadInput() {
  std::string all;
  char block[64 * 1024];
  while (const std::size_t got = std::fread(block, 1, sizeof(block), stdin)) all.append(block, got);
  return all;
}

void TellParent(const Result<std::string>& answer) {
  std::string text(1, answer ? kGood : kBad);
  if (answer) {
    text += *answer;
  } else {
    const Json failure = {{"code", ErrorCodeName(answer.error().code)},
                          {"message", answer.error().message},
                          {"detail", answer.error().detail}};
    text += JsonText(failure);
  }
  WriteAll(STDOUT_FILENO, text);
}

}  // namespace skyquilt::server
