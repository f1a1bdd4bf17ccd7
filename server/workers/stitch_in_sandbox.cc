// The sandboxed side of StitchSandboxed.
#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <exception>
#include <string>
#include <utility>

#include "api/json/job_options.h"
#include "core/base/process/late_library.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/imports/import_map.h"
#include "server/jobs/pipe_progress.h"
#include "server/jobs/stitch_job.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/sandbox/process_limits.h"
#include "server/sandbox/sandbox.h"
#include "server/sandbox/sandboxed_child.h"
#include "server/units/stitch_unit.h"

namespace skyquilt::server {
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
  SKYQUILT_TRY(LoadLate());
  LimitThisProcess(
      {.more_memory_bytes = task.memory_bytes, .more_cpu_s = task.cpu_s, .file_bytes = file_bytes});
  FileAccess access{.reads = {task.files_dir}, .writes = {task.out_dir}};
  for (const std::filesystem::path& more : {task.previous_dir, task.units_dir}) {
    if (!more.empty()) access.reads.push_back(more);
  }
  SKYQUILT_TRY(Confine(std::move(access)));
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
    return flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailWorkerMeans, thrown.what());
  }
}

}  // namespace

int StitchInSandbox(int parent) {
  auto writer = MeetParent(parent);
  if (!writer) return 1;
  MessageReader reader = ParentsMessages();
  const std::optional<std::string> task = reader.Read(std::chrono::minutes(1));
  if (!task) return 1;
  Result<StitchOutcome> outcome = RunStitchTask(*task, *writer);
  const JobMessage last = outcome ? JobMessage(*std::move(outcome)) : JobMessage(outcome.error());
  return writer->Write(ToText(last)) ? 0 : 1;
}

}  // namespace skyquilt::server
