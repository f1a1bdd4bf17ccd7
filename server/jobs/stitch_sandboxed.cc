#include "server/jobs/stitch_sandboxed.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <utility>

#include "core/flight/remarks/because.h"
#include "server/sandbox/sandboxed_child.h"
#include "server/sandbox/spawn_self.h"

namespace skyquilt::server {
namespace {

using flight::Because;
using flight::Remark;
using flight::RemarkCode;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollInterval{50};
// From its last word to its end there is nothing left to do.
constexpr std::chrono::seconds kEndPatience{10};
// Address space is more than memory: files are mapped, and each thread has its stack and arena.
constexpr std::int64_t kAddressSpaceBeyondBytes = std::int64_t{8} << 30;
// The kernel's own limit is a second wall behind the one that is watched here.
constexpr std::int64_t kCpuBeyondS = 30;

// Where the job is, for a person.
struct Whereabouts {
  std::string stage;
  std::string message;

  Remark Said() const {
    if (stage.empty()) return RemarkCode::kBeforeFirstStage;
    if (message.empty()) return {RemarkCode::kInStage, {{"stage", stage}}};
    return {RemarkCode::kInStageAt, {{"stage", stage}, {"at_words", message}}};
  }
};

// What the process took too much of; nothing while it keeps within its limits.
std::optional<Error> Excess(const SandboxedChild& child, const JobLimits& limits, Clock::time_point began,
                            const Whereabouts& where) {
  if (const std::int64_t memory = child.MemoryBytes(); memory > limits.memory_bytes) {
    const double limit_gib = static_cast<double>(limits.memory_bytes) / (1 << 30);
    return Because(ErrorCode::kUnprocessable,
                   {RemarkCode::kFailMemory, {{"limit_gib", limit_gib}, {"where", where.Said()}}},
                   fmt::format("{} bytes", memory));
  }
  const auto too_long = [&](RemarkCode code, std::int64_t limit_s) {
    return Because(ErrorCode::kUnprocessable,
                   {code, {{"limit_s", static_cast<double>(limit_s)}, {"where", where.Said()}}});
  };
  if (Clock::now() - began > limits.wall) return too_long(RemarkCode::kFailTime, limits.wall.count());
  if (child.CpuS() > static_cast<double>(limits.cpu_s))
    return too_long(RemarkCode::kFailProcessorTime, limits.cpu_s);
  return std::nullopt;
}

Error Death(int status, const Whereabouts& where) {
  const bool is_killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  return Because(
      ErrorCode::kInternal,
      {is_killed ? RemarkCode::kFailProcessKilled : RemarkCode::kFailProcessEnded, {{"where", where.Said()}}},
      "it ended " + HowItEnded(status));
}

}  // namespace

StitchedInSandbox StitchSandboxed(StitchTask task, const JobLimits& limits, Progress& progress) {
  task.memory_bytes = limits.memory_bytes + kAddressSpaceBeyondBytes;
  task.cpu_s = limits.cpu_s + kCpuBeyondS;
  const auto began = Clock::now();
  Result<std::unique_ptr<SandboxedChild>> started = SandboxedChild::Start({"stitch-sandboxed"});
  if (!started) return {started.error()};
  SandboxedChild& child = **started;
  Whereabouts where;
  std::optional<Result<StitchOutcome>> said;
  if (child.Tell(ToText(task))) {
    while (!said && !child.is_silent()) {
      if (progress.IsCancelled()) return {Error{ErrorCode::kCancelled, "The job was cancelled.", ""}};
      if (const auto excess = Excess(child, limits, began, where)) return {*excess};
      const std::optional<std::string> text = child.Listen(kPollInterval);
      if (!text) continue;
      Result<JobMessage> message = ParseJobMessage(*text);
      if (!message) return {message.error()};
      if (auto* begun = std::get_if<StageBegun>(&*message)) {
        progress.BeginStage(begun->stage);
        where = {std::move(begun->stage), ""};
      } else if (auto* far = std::get_if<StageProgress>(&*message)) {
        progress.Report(far->fraction, far->message);
        where.message = std::move(far->message);
      } else if (auto* outcome = std::get_if<StitchOutcome>(&*message)) {
        said = std::move(*outcome);
      } else {
        said = std::move(std::get<Error>(*message));
      }
    }
  }
  const int status = child.End(kEndPatience);
  if (!said || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return {Death(status, where), true};
  return {*std::move(said)};
}

}  // namespace skyquilt::server
