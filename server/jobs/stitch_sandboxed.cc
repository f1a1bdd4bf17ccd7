#include "server/jobs/stitch_sandboxed.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <exception>
#include <optional>
#include <string>
#include <utility>

#include "api/json/job_options.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/imports/import_map.h"
#include "server/jobs/pipe_progress.h"
#include "server/jobs/stitch_job.h"
#include "server/jobs/stitch_unit.h"
#include "server/sandbox/sandbox.h"
#include "server/sandbox/sandboxed_child.h"

namespace skyquilt::server {
namespace {

using flight::Because;
using flight::Remark;
using flight::RemarkCode;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollInterval{50};
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
  const Error cancelled{ErrorCode::kCancelled, "The job was cancelled."};
  const auto go_on = [&progress] { return !progress.IsCancelled(); };
  if (!go_on()) return {cancelled};
  Result<std::unique_ptr<SandboxedChild>> started =
      SandboxedChild::Start("stitch-sandboxed", ToText(task), go_on);
  if (!started) return {started.error()};
  SandboxedChild& child = **started;
  Whereabouts where;
  std::optional<Result<StitchOutcome>> said;
  while (!said && !child.is_silent()) {
    if (!go_on()) return {cancelled};
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
  const int status = child.End().wait_status;
  // Ended for that, perhaps, in the middle of its own end.
  if (status != 0 && !go_on()) return {cancelled};
  // An error that it told stands, however it ended after that.
  if (said && (status == 0 || !*said)) return {*std::move(said)};
  return {Death(status, where), true};
}

// What that process does.
namespace {

// A map of the most pixels that are rendered (core/render/plan_mosaic) is smaller.
constexpr std::int64_t kFileBytes = std::int64_t{1} << 40;

// The folder may be that of an attempt that was killed a moment ago and is not quite dead: two must never
// write into one. Held for the life of this process.
bool TakeFolder(const std::filesystem::path& folder) {
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  int failed = 0;
  do {
    failed = flock(fd, LOCK_EX);
  } while (failed != 0 && errno == EINTR);
  return failed == 0;
}

StitchOutcome OutcomeOf(const pipeline::MosaicReport& report) {
  StitchOutcome outcome;
  outcome.figures.bounds = report.bounds;
  outcome.figures.min_zoom = report.min_zoom;
  outcome.figures.max_zoom = report.max_zoom;
  outcome.figures.gsd_m = report.gsd_m;
  outcome.figures.photos_total = report.photos_total;
  outcome.figures.photos_aligned = report.photos_aligned;
  outcome.figures.photos_pose_only = report.photos_pose_only;
  outcome.figures.photos_left_out = report.photos_left_out;
  if (report.captured) {
    outcome.figures.first_capture = report.captured->first;
    outcome.figures.last_capture = report.captured->last;
  }
  outcome.figures.quality = pipeline::QualityJson(report.quality);
  for (const auto& timing : report.timings) outcome.stages_s.emplace_back(timing.stage, timing.wall_s);
  return outcome;
}

Result<StitchOutcome> Stitch(const StitchTask& task, pipeline::MosaicOptions options, Progress& progress) {
  const UnitFiles units(task.units_dir);
  if (task.unit) {
    SKYQUILT_TRY_ASSIGN(UnitDone done,
                        StitchUnit(task.files, *task.unit, units, task.out_dir, options, progress));
    return StitchOutcome{.figures = {}, .stages_s = std::move(done.stages_s), .blocks = done.blocks};
  }
  StitchJobOptions job;
  job.mosaic = std::move(options);
  job.previous_dir = task.previous_dir;
  job.write_pmtiles = task.with_pmtiles;
  if (!task.units_dir.empty()) {
    job.facts_file = units.Facts();
    for (int number = 0; number < task.renders; ++number)
      job.part_dirs.push_back(units.Folder(UnitKind::kRender, number));
  }
  SKYQUILT_TRY_ASSIGN(const pipeline::MosaicReport report,
                      StitchToDirectory(task.files, job, task.out_dir, progress));
  return OutcomeOf(report);
}

Result<StitchOutcome> RunStitchTask(const std::string& text, MessageWriter& writer) {
  SKYQUILT_TRY_ASSIGN(const StitchTask task, ParseTask(text));
  SKYQUILT_TRY_ASSIGN(pipeline::MosaicOptions options, api::ParseJobOptions(task.options));
  options.title = task.title;
  const bool is_import = !options.import_file.empty();
  if (!TakeFolder(task.out_dir))
    return Error{ErrorCode::kIo, "The server could not use the folder of the job.", task.out_dir.string()};
  KeepTemporaryFilesIn(task.out_dir);
  const std::int64_t file_bytes = is_import ? RoomForImport(task.out_dir) : kFileBytes;
  // A file that grows beyond its limit is an error of writing, which the import tells of.
  if (is_import) signal(SIGXFSZ, SIG_IGN);
  SandboxNeeds needs{
      .limits = {.more_memory_bytes = task.memory_bytes, .more_cpu_s = task.cpu_s, .file_bytes = file_bytes},
      .files = {.reads = {task.files_dir}, .writes = {task.out_dir}}};
  for (const std::filesystem::path& more : {task.previous_dir, task.units_dir}) {
    if (!more.empty()) needs.files.reads.push_back(more);
  }
  SKYQUILT_TRY(EnterSandbox(std::move(needs)));
  PipeProgress progress(writer);
  try {
    if (is_import) {
      const ImportJob import{task.out_dir, task.with_pmtiles};
      SKYQUILT_TRY_ASSIGN(const pipeline::MosaicReport report,
                          ImportForJob(task.files, options, import, progress));
      return OutcomeOf(report);
    }
    return Stitch(task, std::move(options), progress);
  } catch (const std::exception& thrown) {
    return Because(ErrorCode::kInternal, RemarkCode::kFailWorkerMeans, thrown.what());
  }
}

}  // namespace

int StitchInSandbox(int parent) {
  return WorkForParent(parent, [](const std::string& task, MessageReader&, MessageWriter& to_parent) {
    Result<StitchOutcome> outcome = RunStitchTask(task, to_parent);
    const JobMessage last = outcome ? JobMessage(*std::move(outcome)) : JobMessage(outcome.error());
    return to_parent.Write(ToText(last)) ? 0 : 1;
  });
}

}  // namespace skyquilt::server
