#include "server/sandbox/run_sandboxed.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "server/routing/request_log.h"
#include "server/sandbox/sandboxed_child.h"

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

constexpr std::chrono::milliseconds kStopPollInterval{100};  // how soon a stopping server is noticed

std::atomic<bool> is_ending{false};

double SecondsOf(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// What came over the pipe is what a process said that may have been taken over: nothing of it is believed.
Result<std::string> Understand(std::string text, const std::string& refusal) {
  const Json said = ParseJson(text);
  if (!said.is_discarded() && !said.contains("error")) return text;
  const std::optional<Error> error = said.is_discarded() ? std::nullopt : ErrorOfJson(said.at("error"));
  return error ? *error : Error{ErrorCode::kUnprocessable, refusal, "its answer cannot be read"};
}

}  // namespace

Result<std::string> RunSandboxed(const SandboxedTask& task) {
  const Error stopping{ErrorCode::kUnavailable, "The server is stopping. Try again later.", task.command};
  if (is_ending) return stopping;
  const Clock::time_point begun = Clock::now();
  const Clock::time_point end = begun + task.deadline;
  const auto go_on = [] { return !is_ending; };
  SKYQUILT_TRY_ASSIGN(const auto child,
                      SandboxedChild::Start(task.command, task.task, go_on, task.max_answer_bytes));
  std::optional<std::string> answer;
  while (!answer && !child->is_silent() && !is_ending && Clock::now() < end) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
    answer = child->Listen(std::min(left, kStopPollInterval));
  }
  const bool is_cut_short = !answer && !child->is_silent();
  const ProcessEnd& ended = is_cut_short ? child->Kill() : child->End();
  const bool is_well = answer && ended.wait_status == 0;
  // Who has not ended well by then was ended for that, and not for its files, as far as anybody can tell.
  const bool is_stopped = !is_well && is_ending;
  const std::string how = is_well                       ? "well"
                          : is_cut_short && !is_stopped ? "it took too long"
                          : child->has_said_too_much()  ? "it said too much"
                                                        : HowItEnded(ended.wait_status);
  LogEvent(fmt::format("{} apart: {:.2f} s, {:.2f} s of CPU, {} MiB, ended {}", task.command,
                       std::chrono::duration<double>(Clock::now() - begun).count(),
                       SecondsOf(ended.used.ru_utime) + SecondsOf(ended.used.ru_stime),
                       ended.used.ru_maxrss >> 10, how));
  if (is_stopped) return stopping;
  const Error unwell{ErrorCode::kUnprocessable, task.refusal, "it ended: " + how};
  if (!answer) return unwell;
  Result<std::string> understood = Understand(*std::move(answer), task.refusal);
  // An error that it told stands, however it ended after that.
  if (understood && !is_well) return unwell;
  return understood;
}

void EndAllSandboxed() { is_ending = true; }

int AnswerParent(int parent, const std::function<Result<std::string>(const std::string& task)>& work) {
  return WorkForParent(parent, [&](const std::string& task, MessageReader&, MessageWriter& to_parent) {
    Result<std::string> answer = work(task);
    if (!answer) {
      const Json failure = {{"error", ErrorJson(answer.error())}};
      answer = JsonText(failure);
    }
    return to_parent.Write(*answer) ? 0 : 1;
  });
}

}  // namespace skyquilt::server
