// The sandboxed side of ExportSandboxed.
#include <signal.h>

#include <chrono>
#include <exception>
#include <optional>
#include <string>

#include "core/base/process/late_library.h"
#include "core/base/try.h"
#include "server/exports/export_sandboxed.h"
#include "server/exports/export_task.h"
#include "server/jobs/job_messages.h"
#include "server/jobs/pipe_progress.h"
#include "server/reports/map_picture.h"
#include "server/sandbox/process_limits.h"
#include "server/sandbox/sandbox.h"
#include "server/sandbox/sandboxed_child.h"
#include "storage/exports/custom/export_map.h"
#include "storage/files/publish_file.h"

namespace skyquilt::server {
namespace {

Result<void> RunExportTask(const std::string& text, MessageWriter& writer) {
  SKYQUILT_TRY_ASSIGN(const ExportTask task, ParseExportTask(text));
  KeepTemporaryFilesIn(task.work_dir);
  // A file that grows beyond its limit is an error of writing.
  signal(SIGXFSZ, SIG_IGN);
  StepBack();
  SKYQUILT_TRY(LoadLate());
  LimitThisProcess(
      {.more_data_bytes = task.memory_bytes, .more_cpu_s = task.cpu_s, .file_bytes = task.file_bytes});
  SKYQUILT_TRY(Confine({.reads = {task.map_dir}, .writes = {task.work_dir}}));
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
  auto writer = MeetParent(parent);
  if (!writer) return 1;
  MessageReader reader = ParentsMessages();
  const std::optional<std::string> task = reader.Read(std::chrono::minutes(1));
  if (!task) return 1;
  const Result<void> outcome = RunExportTask(*task, *writer);
  if (outcome) return 0;
  writer->Write(ToText(JobMessage(outcome.error())));
  return 1;
}

}  // namespace skyquilt::server
