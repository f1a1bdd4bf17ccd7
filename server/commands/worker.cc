#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "core/base/process/late_library.h"
#include "core/base/try.h"
#include "server/commands/commands.h"
#include "server/open_storage.h"
#include "server/preview/preview_sandboxed.h"
#include "server/routing/request_log.h"
#include "server/sandbox/sandbox.h"
#include "server/terminal/fail.h"
#include "server/units/run_unit.h"
#include "server/usage/storage_options.h"
#include "server/workers/run_job.h"
#include "storage/db/ids.h"
#include "storage/db/machine_boot.h"
#include "storage/folder/data_dir_watch.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/open_data_folder.h"
#include "storage/jobs/workers_aside.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kPoll{200};
// What nobody tells, such as a lease that ran out or a time that came, is looked for by itself so often.
constexpr std::chrono::seconds kLookAnyway{2};
constexpr std::chrono::seconds kLookAnywayShared{10};  // a server of PostgreSQL has others to answer
constexpr std::chrono::seconds kPatience{30};          // with a database that is restarted
constexpr std::chrono::minutes kPatienceAtStart{15};
constexpr std::chrono::seconds kLongestPreviewPause{30};
// Who is asked to stop does so; what it could not take back is forgotten by itself.
constexpr std::chrono::seconds kPatienceAtEnd{1};

struct WorkerOptions {
  std::string data_dir;
  CatalogueOptions catalogue;
  storage::BlobPlace blobs;
  std::string name;
  int parent = 0;
  int jobs = 0;             // 0: any number
  int job_timeout_s = 0;    // 0: by what was uploaded
  int job_memory_mib = 0;   // 0: by what was uploaded
  int photo_timeout_s = 0;  // 0: as PhotoLimits says
  int cut_above = kCutAboveFiles;
  int part_files = static_cast<int>(pipeline::kFilesPerLook);
  bool once = false;
  bool until_empty = false;
  bool previews = false;
};

// Exit code of --once where no job waits: a launcher that starts one worker per job can stop starting them.
constexpr int kNothingToDo = 3;

std::atomic<bool> is_stopping{false};

void OnStopSignal(int) { is_stopping = true; }

// What is away when a worker starts is waited for, as it is in the middle of a job.
template <typename Open>
auto Patiently(Open open) {
  const auto end = std::chrono::steady_clock::now() + kPatienceAtStart;
  bool is_said = false;
  while (true) {
    auto opened = open();
    const bool may_pass = !opened && opened.error().code == ErrorCode::kUnavailable;
    if (!may_pass || std::chrono::steady_clock::now() > end) return opened;
    if (!std::exchange(is_said, true)) LogEvent("the worker waits: " + opened.error().message);
    for (int polls = 0; polls < 5; ++polls) {
      if (is_stopping) throw CLI::RuntimeError(0);
      std::this_thread::sleep_for(kPoll);
    }
  }
}

// In a folder that is gone the open catalogue has no name any more: no job would ever be found in it. False:
// the worker is to stop.
bool AwaitFolder(const std::optional<storage::DataDirWatch>& watch, const WorkerOptions& options) {
  for (bool is_said = false; !is_stopping; std::this_thread::sleep_for(kPoll)) {
    const Result<void> in_place = watch ? watch->Check() : Result<void>();
    if (in_place && is_said) LogEvent("the data folder is back: the worker goes on");
    if (in_place) return true;
    if (options.once || options.until_empty) Fail("skyquilt worker", in_place.error());
    if (!std::exchange(is_said, true)) LogEvent("the worker waits: " + in_place.error().message);
  }
  return false;
}

// Whether a worker that is to stop by itself gives up: at once where it works once, for whoever started it
// decides when to start the next; else after a while of failures alone.
class Patience {
 public:
  explicit Patience(const WorkerOptions& options) : options_(options) {}
  void Worked() { since_.reset(); }
  bool IsOverAfterFailure() {
    const auto now = std::chrono::steady_clock::now();
    if (!since_) since_ = now;
    return options_.once || (options_.until_empty && now - *since_ >= kPatience);
  }

 private:
  const WorkerOptions& options_;
  std::optional<std::chrono::steady_clock::time_point> since_;
};

void DrawPreviews(const storage::DataDir& dir, storage::BlobStore& blobs, storage::CatalogueDb& db,
                  const std::optional<storage::DataDirWatch>& watch, const WorkerOptions& options) {
  storage::Previews previews(db);
  PhotoLimits limits;
  if (options.photo_timeout_s > 0) limits.cpu_s = options.photo_timeout_s;
  SandboxedPreview drawing(dir, blobs, previews, limits, is_stopping);
  Patience patience(options);
  int failures = 0;  // in a row
  while (AwaitFolder(watch, options)) {
    const Result<bool> drawn = drawing.Step();
    if (!drawn) {
      LogFailure("-", "preview", drawn.error());
      if (patience.IsOverAfterFailure()) Fail("skyquilt worker", drawn.error());
      // What waits is tried for as long as it fails: on a full disk for hours.
      const auto pause = std::min(kLongestPreviewPause, std::chrono::seconds(1 << std::min(failures++, 10)));
      const auto end = std::chrono::steady_clock::now() + pause;
      while (!is_stopping && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(kPoll);
      continue;
    }
    failures = 0;
    patience.Worked();
    if (!*drawn) {
      if (options.once || options.until_empty) return;
      const auto end = std::chrono::steady_clock::now() + kLookAnyway;
      while (!is_stopping && !db.WaitForWrites() && std::chrono::steady_clock::now() < end) continue;
    }
  }
}

// Unlike that of any other process, on this machine or another.
std::string NameOfWorker(const storage::CatalogueDb& db) {
  if (!db.IsShared()) return fmt::format("worker-{}", getpid());
  return fmt::format("worker-{}-{}-{}", storage::MachineBoot::HostName(), getpid(), storage::NewId());
}

// A part of a large flight, or a job; which of them is looked for first is chance, so that neither waits for
// all of the others. False: there is nothing to do.
Result<bool> WorkOnce(WorkerContext& context, const std::string& name) {
  static std::minstd_rand chance(static_cast<unsigned>(getpid()));
  const bool units_first = chance() % 2 == 0;
  for (const bool is_unit : {units_first, !units_first}) {
    if (is_unit) {
      SKYQUILT_TRY_ASSIGN(const auto unit, context.units.Claim(name, storage::Now()));
      if (unit) {
        RunUnit(context, *unit);
        return true;
      }
    } else {
      SKYQUILT_TRY_ASSIGN(const auto lease, context.queue.Claim(name, storage::Now()));
      if (lease) {
        RunJob(context, *lease);
        return true;
      }
    }
  }
  return false;
}

// After trouble of this machine it takes nothing for a while, and says so where its work is seen; what it had
// is another's by now.
class Aside {
 public:
  Aside(storage::CatalogueDb& db, std::string name) : db_(db), workers_(db), name_(std::move(name)) {}
  ~Aside() {
    db_.SetPatience(kPatienceAtEnd);
    Clear();
  }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  void After(const Error& fault) {
    const auto pause = storage::PauseAside(++times_);
    LogFailure("-", "machine",
               fmt::format("{} {} What this worker had was given back; it takes nothing for {} s.",
                           fault.message, fault.detail, pause.count()));
    const Result<void> put = workers_.Put(name_, times_, fault, storage::Now());
    if (!put) LogFailure("-", "aside", put.error());
    const auto end = std::chrono::steady_clock::now() + pause;
    while (!is_stopping && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(kPoll);
  }
  void Clear() {
    if (std::exchange(times_, 0) == 0) return;
    const Result<void> cleared = workers_.Clear(name_);
    if (!cleared) LogFailure("-", "aside", cleared.error());
  }

 private:
  storage::CatalogueDb& db_;
  storage::WorkersAside workers_;
  const std::string name_;
  int times_ = 0;
};

void RunWorker(const WorkerOptions& options) {
  signal(SIGTERM, OnStopSignal);
  signal(SIGINT, OnStopSignal);
  signal(SIGPIPE, SIG_IGN);  // a process it started may die before it has heard all
  // A worker whose server died must not go on for nobody.
  if (options.parent != 0 && !FollowParent(options.parent, SIGTERM)) return;
  StepBack();
  OrFail("skyquilt worker", LoadLate());
  LimitThisProcess({});
  const storage::CataloguePlace given = PlaceOf("skyquilt worker", options.catalogue);
  const storage::CataloguePlace place =
      OrFail("skyquilt worker", Patiently([&] { return storage::WithFilesAt(given, options.blobs); }));
  storage::OpenedDataFolder opened =
      OrFail("skyquilt worker", Patiently([&] { return storage::JoinDataFolder(options.data_dir, place); }));
  const storage::DataDir* const dir = &opened.dir;
  storage::CatalogueDb* const db = opened.db.get();
  db->SetPatience(kPatience);
  std::optional<storage::DataDirWatch> watch;  // where the catalogue lies in the folder
  if (!place.IsPostgres()) watch = OrFail("skyquilt worker", storage::DataDirWatch::Begin(*dir));
  const std::shared_ptr<storage::BlobStore> blobs =
      OrFail("skyquilt worker", Patiently([&] { return OpenBlobsOf(*dir, *db, options.blobs); }));
  if (options.previews) {
    DrawPreviews(*dir, *blobs, *db, watch, options);
    return;
  }
  storage::Catalogue catalogue(*db);
  storage::JobQueue queue(*db);
  storage::StageCosts costs(*db);
  storage::UnitQueue units(*db);
  WorkerContext context{*dir, *blobs, catalogue, queue, costs, units, is_stopping};
  context.cut_above_files = options.cut_above;
  context.files_per_unit = options.part_files;
  context.is_shared = place.IsOfManyFolders();
  if (options.job_timeout_s > 0) context.limits.timeout = std::chrono::seconds(options.job_timeout_s);
  context.limits.machine_memory_bytes = MemoryOfThisMachine();
  if (options.job_memory_mib > 0) context.limits.memory_bytes = std::int64_t{options.job_memory_mib} << 20;
  const int jobs = options.once ? 1 : options.jobs;
  const std::string name = options.name.empty() ? NameOfWorker(*db) : options.name;
  Aside aside(*db, name);
  Patience patience(options);
  for (int done = 0; (jobs == 0 || done < jobs) && AwaitFolder(watch, options);) {
    if (context.may_hold) {
      // A claim was made and its answer lost, or an end was not heard; nobody works on that.
      context.may_hold = !queue.ReleaseWorker(name, storage::WorkerEnd::kInterrupted, storage::Now()) ||
                         !units.ReleaseWorker(name, storage::WorkerEnd::kInterrupted, storage::Now());
    }
    const Result<bool> worked = WorkOnce(context, name);
    if (!worked) {
      // Busy or full: the queue is polled again; a permanent failure shows in the log.
      LogFailure("-", "claim", worked.error());
      if (patience.IsOverAfterFailure()) Fail("skyquilt worker", worked.error());
      context.may_hold = db->IsShared();
      std::this_thread::sleep_for(std::chrono::seconds(2));
      continue;
    }
    patience.Worked();
    if (*worked && context.fault) {
      if (options.once) Fail("skyquilt worker", *context.fault);
      aside.After(*std::exchange(context.fault, std::nullopt));
    } else if (*worked) {
      aside.Clear();
      ++done;
    } else if (options.once || options.until_empty) {
      if (options.once) throw CLI::RuntimeError(kNothingToDo);
      return;
    } else {
      const auto end = std::chrono::steady_clock::now() + (db->IsShared() ? kLookAnywayShared : kLookAnyway);
      while (!is_stopping && !queue.WaitForJobs() && std::chrono::steady_clock::now() < end) continue;
    }
  }
}

}  // namespace

void AddWorkerCommand(CLI::App& app) {
  const auto options = std::make_shared<WorkerOptions>();
  CLI::App* command =
      app.add_subcommand("worker", "Run the queued jobs of a data folder (serve starts its own)");
  command->add_option("--data", options->data_dir, "Data folder")->required();
  AddBlobOptions(*command, options->blobs);
  AddCatalogueOptions(*command, options->catalogue);
  command->add_option(
      "--name", options->name,
      "Name in the queue (default: worker-<process id>, with the machine's name where machines share it)");
  command->add_option("--parent", options->parent, "Stop when this process is gone");
  // A negative number would be none without a word.
  const auto add_number = [&](const char* name, int& value, int most, const char* what) {
    command->add_option(name, value, what)->check(CLI::Range(0, most));
  };
  add_number("--jobs", options->jobs, 1'000'000, "Stop after this many jobs (default: never)");
  add_number("--job-timeout", options->job_timeout_s, 30 * 24 * 3600,
             "Seconds that a job may take (default: by what was uploaded)");
  add_number("--job-memory", options->job_memory_mib, 1 << 24,
             "MiB of memory that a job may take (default: by what was uploaded)");
  add_number("--photo-timeout", options->photo_timeout_s, 24 * 3600,
             "Seconds of processor time that the preview of a photo may take (default: 60)");
  command
      ->add_option("--cut-above", options->cut_above,
                   "Flights of more files are cut into parts that several workers share; 0: none is")
      ->check(CLI::Range(0, 1 << 24))
      ->capture_default_str();
  command->add_option("--part-files", options->part_files, "Files that one part of them looks at")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_flag(
      "--once", options->once,
      "Run one job, or one part of a large flight, and stop; exit code 3 where none waits (for Slurm arrays and Kubernetes Jobs)");
  command->add_flag("--until-empty", options->until_empty, "Stop when the queue is empty");
  command->add_flag("--previews", options->previews,
                    "Draw the previews of flights that are still uploading instead");
  command->callback([options] { RunWorker(*options); });
}

}  // namespace skyquilt::server
