#include "server/exports/export_sandboxed.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <optional>
#include <system_error>
#include <variant>

#include "core/base/try.h"
#include "server/jobs/pipe_progress.h"
#include "server/reports/map_picture.h"
#include "server/sandbox/sandbox.h"
#include "server/sandbox/sandboxed_child.h"
#include "storage/exports/custom/export_map.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kExportPollInterval{200};
// The least that an export is given to write, however full the disk is.
constexpr std::int64_t kMinFileBytes = std::int64_t{1} << 20;

Error DiskFull() {
  return {ErrorCode::kOutOfSpace,
          "The server's disk has no room for this export. Ask for a smaller area or a coarser resolution."};
}

// Stages without a share of their own: cutting and gathering come first, writing is the most of it.
double Overall(const std::string& stage, double fraction) {
  return stage == "export" ? 0.3 + 0.7 * fraction : 0.3 * fraction;
}

std::optional<Error> OverLimit(const SandboxedChild& child, const ExportTask& task,
                               const ExportLimits& limits, Clock::time_point begun) {
  if (Clock::now() - begun > limits.wall || child.CpuS() > static_cast<double>(task.cpu_s))
    return Error{
        ErrorCode::kTimeout,
        fmt::format("The export took more than {} minutes. Ask for a smaller area or a coarser resolution.",
                    limits.wall.count() / 60)};
  if (const std::int64_t memory = child.MemoryBytes(); memory > limits.memory_bytes)
    return Error{ErrorCode::kUnprocessable,
                 "The export took more memory than the server gives for it. Ask for a smaller area.",
                 fmt::format("{} bytes", memory)};
  const Result<std::int64_t> room = FreeBytes(task.work_dir);
  if (!room) return room.error();
  if (*room < limits.keep_free_bytes) return DiskFull();
  return std::nullopt;
}

// A link would lead to what the process itself may not read.
Result<std::int64_t> SizeOf(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error)))
    return Error{ErrorCode::kInternal, "The export ended without a file.", path.string()};
  return static_cast<std::int64_t>(fs::file_size(path, error));
}

}  // namespace

Result<std::int64_t> FreeBytes(const fs::path& folder) {
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) return storage::FileError("cannot look at", folder, errno);
  return static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize);
}

Result<std::int64_t> ExportSandboxed(ExportTask task, const ExportLimits& limits,
                                     const std::function<bool(double fraction)>& go_on) {
  SKYQUILT_TRY_ASSIGN(const std::int64_t free_bytes, FreeBytes(task.work_dir));
  const std::int64_t room = free_bytes - limits.keep_free_bytes;
  if (room < kMinFileBytes) return DiskFull();
  task.file_bytes = room;
  task.memory_bytes = limits.memory_bytes;
  task.cpu_s = limits.wall.count() * std::max(1, task.threads);
  const Error cancelled{ErrorCode::kCancelled, "The export was cancelled."};
  double fraction = 0.0;
  bool is_wanted = true;  // `go_on` looks now and then, and need not say no twice
  const auto ask = [&] {
    is_wanted = is_wanted && go_on(fraction);
    return is_wanted;
  };
  SKYQUILT_TRY_ASSIGN(const auto child, SandboxedChild::Start("export-sandboxed", ToText(task), ask));
  const Clock::time_point begun = Clock::now();
  std::string stage;
  std::optional<Error> said;
  while (!child->is_silent()) {
    if (!ask()) return cancelled;
    if (const auto over = OverLimit(*child, task, limits, begun)) return *over;
    const std::optional<std::string> text = child->Listen(kExportPollInterval);
    if (!text) continue;
    SKYQUILT_TRY_ASSIGN(const JobMessage message, ParseJobMessage(*text));
    if (const auto* begins = std::get_if<StageBegun>(&message)) stage = begins->stage;
    if (const auto* progress = std::get_if<StageProgress>(&message))
      fraction = Overall(stage, progress->fraction);
    if (const auto* error = std::get_if<Error>(&message)) said = *error;
  }
  const int status = child->End().wait_status;
  if (said) return *said;
  if (status != 0 && !is_wanted) return cancelled;
  if (status != 0)
    return Error{ErrorCode::kUnprocessable,
                 "The export could not be made: its process ended. Ask for a smaller area or another format.",
                 HowItEnded(status)};
  return SizeOf(task.work_dir / task.out_name);
}

// What that process does.
namespace {

Result<void> RunExportTask(const std::string& text, MessageWriter& writer) {
  SKYQUILT_TRY_ASSIGN(const ExportTask task, ParseExportTask(text));
  KeepTemporaryFilesIn(task.work_dir);
  // A file that grows beyond its limit is an error of writing.
  signal(SIGXFSZ, SIG_IGN);
  SKYQUILT_TRY(EnterSandbox({.limits = {.more_data_bytes = task.memory_bytes,
                                        .more_cpu_s = task.cpu_s,
                                        .file_bytes = task.file_bytes},
                             .files = {.reads = {task.map_dir}, .writes = {task.work_dir}}}));
  PipeProgress progress(writer);
  try {
    SKYQUILT_TRY_ASSIGN(const storage::ExportRequest request, storage::ParseExportRequest(task.request));
    if (request.format == storage::ExportFormat::kReport) {
      // Its pixels alone: what is printed beside the sandbox is a page of the server's own.
      SKYQUILT_TRY_ASSIGN(const MapPixels pixels, MakeMapPixels(task.map_dir, kReportPicturePx, task.threads,
                                                                task.work_dir, progress));
      return storage::WriteFileAtomically(task.work_dir / task.out_name, ToBytes(pixels));
    }
    SKYQUILT_TRY_ASSIGN(const storage::ExportSource source, storage::ExportSourceOf(task.map_dir));
    const storage::ExportOptions options{.threads = task.threads};
    return storage::ExportMap(source, request, task.work_dir, task.work_dir / task.out_name, options,
                              progress);
  } catch (const std::exception& thrown) {
    return Error{ErrorCode::kOutOfSpace,
                 "The server ran out of memory for this export. Ask for a smaller area.", thrown.what()};
  }
}

}  // namespace

int ExportInSandbox(int parent) {
  return WorkForParent(parent, [](const std::string& task, MessageReader&, MessageWriter& to_parent) {
    const Result<void> made = RunExportTask(task, to_parent);
    if (!made) to_parent.Write(ToText(JobMessage(made.error())));
    return made ? 0 : 1;
  });
}

}  // namespace skyquilt::server
