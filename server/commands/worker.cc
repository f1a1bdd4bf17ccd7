#include "server/commands/worker.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "server/preview_painter.h"
#include "server/process_limits.h"
#include "server/request_log.h"
#include "server/run_job.h"
#include "storage/open_data_folder.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kPoll{200};

struct WorkerOptions {
  std::string data_dir;
  std::string name;
  int parent = 0;
  int jobs = 0;  // 0: any number
  bool once = false;
  bool previews = false;
};

std::atomic<bool> is_stopping{false};

void OnStopSignal(int) { is_stopping = true; }

[[noreturn]] void Fail(const Error& error) {
  fmt::print(stderr, "skyquilt worker: {}\n", error.message);
  throw CLI::RuntimeError(1);
}

// What a photo may take of a machine that also has tiles to serve: decoders have been talked into more.
constexpr std::int64_t kPreviewMemoryBytes = std::int64_t{2560} << 20;
// A photo that keeps its decoder busy for longer ends this process; it counts as tried, and the next one goes
// on.
constexpr std::int64_t kPreviewStepCpuS = 60;
// No job comes near (the budget for photos and tiles is 1 GiB), but one that a codec was talked into ends
// here instead of taking the machine with it. Address space is more than memory: files are mapped, and each
// thread has its stack and arena.
constexpr std::int64_t kJobMemoryBytes = std::int64_t{12} << 30;
// A map of the most pixels that are rendered (core/render/plan_mosaic) is smaller.
constexpr std::int64_t kJobFileBytes = std::int64_t{1} << 40;

void DrawPreviews(const storage::DataDir& dir, storage::CatalogueDb& db, bool once) {
  LimitThisProcess({.more_memory_bytes = kPreviewMemoryBytes});
  storage::Previews previews(db);
  PreviewPainter painter(dir, previews);
  while (!is_stopping) {
    LimitThisProcess({.more_cpu_s = kPreviewStepCpuS});
    const Result<bool> drawn = painter.Step();
    if (!drawn) {
      LogFailure("-", "preview", drawn.error().message + " " + drawn.error().detail);
      std::this_thread::sleep_for(std::chrono::seconds(1));
    } else if (!*drawn) {
      if (once) return;
      std::this_thread::sleep_for(kPoll);
    }
  }
}

void RunWorker(const WorkerOptions& options) {
  signal(SIGTERM, OnStopSignal);
  signal(SIGINT, OnStopSignal);
  // A worker whose server died must not go on for nobody.
  if (options.parent != 0 && !FollowParent(options.parent, SIGTERM)) return;
  StepBack();
  Result<storage::OpenedDataFolder> opened = storage::JoinDataFolder(options.data_dir);
  if (!opened) Fail(opened.error());
  const storage::DataDir* const dir = &opened->dir;
  storage::CatalogueDb* const db = opened->db.get();
  if (options.previews) {
    DrawPreviews(*dir, *db, options.once);
    return;
  }
  LimitThisProcess({.more_memory_bytes = kJobMemoryBytes, .file_bytes = kJobFileBytes});
  storage::Catalogue catalogue(*db);
  storage::JobQueue queue(*db);
  storage::StageCosts costs(*db);
  WorkerContext context{*dir, catalogue, queue, costs, is_stopping, options.parent != 0};
  const std::string name = options.name.empty() ? fmt::format("worker-{}", getpid()) : options.name;
  for (int done = 0; !is_stopping && (options.jobs == 0 || done < options.jobs);) {
    const Result<std::optional<storage::Lease>> lease = queue.Claim(name, storage::Now());
    if (!lease) {
      // Busy or full: the queue is asked again; what is broken for good shows in the log.
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
  command->add_flag("--once", options->once, "Stop when the queue is empty");
  command->add_flag("--previews", options->previews,
                    "Draw the previews of flights that are still uploading instead");
  command->callback([options] { RunWorker(*options); });
}

}  // namespace skyquilt::server
