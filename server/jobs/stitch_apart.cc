#include "server/jobs/stitch_apart.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <utility>

#include "server/confinement/confined_child.h"
#include "server/confinement/spawn_self.h"

namespace skyquilt::server {
namespace {

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

  std::string InWords() const {
    if (stage.empty()) return "before its first stage";
    return message.empty() ? fmt::format("in the stage \"{}\"", stage)
                           : fmt::format("in the stage \"{}\" ({})", stage, message);
  }
};

std::string Gib(std::int64_t bytes) {
  return fmt::format("{:.1f} GiB", static_cast<double>(bytes) / (1 << 30));
}

std::string Minutes(double seconds) {
  return seconds < 120 ? fmt::format("{:.0f} seconds", seconds) : fmt::format("{:.0f} minutes", seconds / 60);
}

// What the process took too much of; nothing while it keeps within its limits.
std::optional<Error> Excess(const ConfinedChild& child, const JobLimits& limits, Clock::time_point began,
                            const Whereabouts& where) {
  constexpr const char* kAdvice =
      "One of the files may be damaged or made to do this: take out what is no ordinary photo";
  if (const std::int64_t memory = child.MemoryBytes(); memory > limits.memory_bytes) {
    return Error{
        ErrorCode::kUnprocessable,
        fmt::format("The job was ended because it needed more than {} of memory {}. {}, or make the map "
                    "of fewer photos. Whoever runs the server can give jobs more with --job-memory.",
                    Gib(limits.memory_bytes), where.InWords(), kAdvice),
        fmt::format("{} bytes", memory)};
  }
  const auto too_long = [&](double limit_s, const char* of_what) {
    return Error{
        ErrorCode::kUnprocessable,
        fmt::format("The job was ended because it took more than {}{} and was still {}. {}. Whoever runs "
                    "the server can give jobs more time with --job-timeout.",
                    Minutes(limit_s), of_what, where.InWords(), kAdvice),
        ""};
  };
  if (Clock::now() - began > limits.wall) return too_long(static_cast<double>(limits.wall.count()), "");
  if (child.CpuS() > static_cast<double>(limits.cpu_s))
    return too_long(static_cast<double>(limits.cpu_s), " of processor time");
  return std::nullopt;
}

Error Death(int status, const Whereabouts& where) {
  const bool is_killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  return {
      ErrorCode::kInternal,
      fmt::format("The process that made the map ended unexpectedly {}{}. Try fewer or other photos if it "
                  "does so again.",
                  where.InWords(), is_killed ? "; the machine may have run out of memory" : ""),
      "it ended " + HowItEnded(status)};
}

}  // namespace

StitchedApart StitchApart(StitchTask task, const JobLimits& limits, Progress& progress) {
  task.memory_bytes = limits.memory_bytes + kAddressSpaceBeyondBytes;
  task.cpu_s = limits.cpu_s + kCpuBeyondS;
  const auto began = Clock::now();
  Result<std::unique_ptr<ConfinedChild>> started = ConfinedChild::Start({"stitch-confined"});
  if (!started) return {started.error()};
  ConfinedChild& child = **started;
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
