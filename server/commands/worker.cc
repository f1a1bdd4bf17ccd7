#include "server/commands/worker.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "server/commands/fail.h"
#include "server/confinement/process_limits.h"
#include "server/jobs/run_job.h"
#include "server/preview/preview_apart.h"
#include "server/routing/request_log.h"
#include "storage/folder/open_data_folder.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kPoll{200};

struct WorkerOptions {
  std::string data_dir;
  std::string name;
  int parent = 0;
  int jobs = 0;             // 0: any number
  int job_timeout_s = 0;    // 0: by what was uploaded
  int job_memory_mib = 0;   // 0: by what was uploaded
  int photo_timeout_s = 0;  // 0: as PhotoLimits says
  bool once = false;
  bool previews = false;
};

std::atomic<bool> is_stopping{false};

void OnStopSignal(int) { is_stopping = true; }

void DrawPreviews(const storage::DataDir& dir, storage::CatalogueDb& db, const WorkerOptions& options) {
  storage::Previews previews(db);
  PhotoLimits limits;
  if (options.photo_timeout_s > 0) limits.cpu_s = options.photo_timeout_s;
  PreviewApart drawing(dir, previews, limits);
  while (!is_stopping) {
    const Result<bool> drawn = drawing.Step();
    if (!drawn) {
      LogFailure("-", "preview", drawn.error().message + " " + drawn.error().detail);
      std::this_thread::sleep_for(std::chrono::seconds(1));
    } else if (!*drawn) {
      if (options.once) return;
      std::this_thread::sleep_for(kPoll);
    }
  }
}

void RunWorker(const WorkerOptions& options) {
  signal(SIGTERM, OnStopSignal);
  signal(SIGINT, OnStopSignal);
  signal(SIGPIPE, SIG_IGN);  // a process it started may die before it has heard all
  // A worker whose server died must not go on for nobody.
  if (options.parent != 0 && !FollowParent(options.parent, SIGTERM)) return;
  StepBack();
  LimitThisProcess({});
  Result<storage::OpenedDataFolder> opened = storage::JoinDataFolder(options.data_dir);
  if (!opened) Fail("skyquilt worker", opened.error());
  const storage::DataDir* const dir = &opened->dir;
  storage::CatalogueDb* const db = opened->db.get();
  if (options.previews) {
    DrawPreviews(*dir, *db, options);
    return;
  }
  storage::Catalogue catalogue(*db);
  storage::JobQueue queue(*db);
  storage::StageCosts costs(*db);
  WorkerContext context{*dir, catalogue, queue, costs, is_stopping};
  if (options.job_timeout_s > 0) context.limits.timeout = std::chrono::seconds(options.job_timeout_s);
  context.limits.machine_memory_bytes = MemoryOfThisMachine();
  if (options.job_memory_mib > 0) context.limits.memory_bytes = std::int64_t{options.job_memory_mib} << 20;
  const std::string name = options.name.empty() ? fmt::format("worker-{}", getpid()) : options.name;
  for (int done = 0; !is_stopping && (options.jobs == 0 || done < options.jobs);) {
    const Result<std::optional<storage::Lease>> lease = queue.Claim(name, storage::Now());
    if (!lease) {
      // Busy or full: the queue is polled again; a permanent failure shows in the log.
      LogFailure("-", "claim", lease.error().detail);
      std::this_thread::sleep_for(std::chrono::seconds(2));
    } else if (*lease) {
      RunJob(context, **lease);
      ++done;
    } else if (options.once) {
      return;
    } else {
      std::this_thread::sleep_for(kPoll);
    }
  }
}

}  // namespace

void AddWorkerCommand(CLI::App& app) {
  const auto options = std::make_shared<WorkerOptions>();
  CLI::App* command =
      app.add_subcommand("worker", "Run the queued jobs of a data folder (serve starts its own)");
  command->add_option("--data", options->data_dir, "Data folder")->required();
  command->add_option("--name", options->name, "Name in the queue (default: worker-<process id>)");
  command->add_option("--parent", options->parent, "Stop when this process is gone");
  command->add_option("--jobs", options->jobs, "Stop after this many jobs (default: never)");
  command->add_option("--job-timeout", options->job_timeout_s,
                      "Seconds that a job may take (default: by what was uploaded)");
  command->add_option("--job-memory", options->job_memory_mib,
                      "MiB of memory that a job may take (default: by what was uploaded)");
  command->add_option("--photo-timeout", options->photo_timeout_s,
                      "Seconds of processor time that the preview of a photo may take (default: 60)");
  command->add_flag("--once", options->once, "Stop when the queue is empty");
  command->add_flag("--previews", options->previews,
                    "Draw the previews of flights that are still uploading instead");
  command->callback([options] { RunWorker(*options); });
}

}  // namespace skyquilt::server
