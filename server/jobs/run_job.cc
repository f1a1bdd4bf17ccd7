#include "server/jobs/run_job.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <system_error>
#include <thread>
#include <vector>

#include "api/json/job_options.h"
#include "core/base/try.h"
#include "server/jobs/film_frames.h"
#include "server/jobs/job_progress.h"
#include "server/jobs/stitch_apart.h"
#include "server/routing/request_log.h"
#include "storage/folder/sweep.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using storage::LeaseState;

Error OsError(const std::string& what, int code) {
  const ErrorCode kind = code == ENOSPC || code == EDQUOT ? ErrorCode::kOutOfSpace : ErrorCode::kIo;
  return {kind,
          kind == ErrorCode::kOutOfSpace
              ? "The server's disk is full. Free some space and start the job again."
              : "The server could not store the map.",
          what + ": " + std::strerror(code)};
}

Result<void> Sync(const fs::path& path, int flags) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | flags);
  if (fd < 0) return OsError("open " + path.string(), errno);
  const int failed = fsync(fd);
  const int code = errno;
  close(fd);
  if (failed != 0) return OsError("fsync " + path.string(), code);
  return {};
}

Result<void> SyncTree(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code unknown;  // Sync says what is wrong with it
    SKYQUILT_TRY(entry.is_directory(unknown) ? SyncTree(entry.path()) : Sync(entry.path(), 0));
  }
  if (error) return OsError("list " + folder.string(), error.value());
  return Sync(folder, O_DIRECTORY);
}

// A folder that goes with the scope, unless it is kept.
class WorkFolder {
 public:
  explicit WorkFolder(fs::path path) : path_(std::move(path)) {}
  ~WorkFolder() {
    if (is_kept_) return;
    std::error_code ignored;  // what stays is swept at the next start
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const fs::path& path() const { return path_; }
  void Keep() { is_kept_ = true; }

 private:
  fs::path path_;
  bool is_kept_ = false;
};

// Takes over the folder of a dead attempt of the same job, so that this one goes on where that stopped.
void AdoptEarlierAttempt(const fs::path& work, const storage::Lease& lease) {
  const fs::path own = work / storage::WorkName(lease);
  std::vector<fs::path> earlier;
  std::error_code none;  // without an earlier attempt this one begins anew
  for (const auto& entry : fs::directory_iterator(work, none)) {
    if (entry.path() != own && storage::JobOfWorkName(entry.path().filename().string()) == lease.job_id) {
      earlier.push_back(entry.path());
    }
  }
  std::sort(earlier.begin(), earlier.end());
  for (const fs::path& folder : earlier) {
    if (!fs::exists(own, none)) fs::rename(folder, own, none);
    fs::remove_all(folder, none);
  }
}

// The folder of the map that the flight shows now; empty when it has none.
Result<fs::path> ShownMap(const WorkerContext& context, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, context.catalogue.Revisions(flight_id));
  if (revisions.empty()) return fs::path();
  return context.dir.Revision(flight_id, *std::max_element(revisions.begin(), revisions.end()));
}

StitchedApart Stitch(WorkerContext& context, const storage::Lease& lease, const fs::path& out_dir,
                     Progress& progress) {
  std::error_code error;
  fs::create_directory(out_dir, error);  // below work/, which a data folder that is gone does not have
  if (error) return {OsError("make " + out_dir.string(), error.value())};
  // An earlier attempt may have died between placing a revision and showing it.
  const Result<storage::SweepReport> swept =
      storage::SweepRevisions(context.dir, context.catalogue, lease.flight_id, storage::Now());
  if (!swept) return {swept.error()};
  for (const std::string& line : swept->moved) LogEvent(line);
  const Result<storage::Flight> flight = context.catalogue.GetFlight(lease.flight_id);
  if (!flight) return {flight.error()};
  const Result<std::vector<storage::StoredFile>> files = context.catalogue.ListFiles(lease.flight_id);
  if (!files) return {files.error()};
  const Result<pipeline::MosaicOptions> options = api::ParseJobOptions(lease.options);
  if (!options) return {options.error()};
  const Result<fs::path> shown = ShownMap(context, lease.flight_id);
  if (!shown) return {shown.error()};
  StitchTask task;
  task.files_dir = context.dir.Files(lease.flight_id);
  task.previous_dir = *shown;
  task.out_dir = out_dir;
  task.options = lease.options;
  task.title = flight->name;
  const storage::PhotoStore store(context.dir);
  std::int64_t bytes = 0;
  for (const storage::StoredFile& file : *files) {
    task.files.push_back({file.name, store.PathOf(lease.flight_id, file.stored_name)});
    bytes += file.bytes;
  }
  const auto count = static_cast<std::int64_t>(files->size());
  return StitchApart(std::move(task), LimitsOfJob(count, bytes, *options, context.limits), progress);
}

// What a confined process left: plain files with no second name, nothing that leads elsewhere, and one folder
// of such files, the frames of its films.
Result<void> CheckProducts(const fs::path& folder, bool may_hold_frames = true) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code unknown;
    const fs::file_type type = entry.symlink_status(unknown).type();
    if (may_hold_frames && type == fs::file_type::directory && entry.path().filename() == kFramesFolder) {
      SKYQUILT_TRY(CheckProducts(entry.path(), false));
    } else if (type != fs::file_type::regular || entry.hard_link_count(unknown) != 1) {
      return Error{ErrorCode::kInternal, "The process that made the map left what is no map.",
                   entry.path().string()};
    }
  }
  if (error) return OsError("list " + folder.string(), error.value());
  return {};
}

// Folders of revisions that the publish retired. The one shown before stays for readers who just looked it
// up.
void RemoveRetired(WorkerContext& context, const std::string& flight_id,
                   const std::vector<std::int64_t>& before) {
  const Result<std::vector<std::int64_t>> after = context.catalogue.Revisions(flight_id);
  if (!after) return;  // the sweep of the next start removes them
  for (const std::int64_t revision : before) {
    if (std::find(after->begin(), after->end(), revision) != after->end()) continue;
    std::error_code ignored;  // as above
    fs::remove_all(context.dir.Revision(flight_id, revision), ignored);
  }
}

// False: the lease was lost, and nothing was shown.
Result<bool> Publish(WorkerContext& context, const storage::Lease& lease, const fs::path& made,
                     storage::Revision revision) {
  SKYQUILT_TRY(CheckProducts(made));
  SKYQUILT_TRY(SyncTree(made));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> before, context.catalogue.Revisions(lease.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::int64_t> number, context.queue.ReserveRevision(lease));
  if (!number) return false;
  // One rename puts all products in place; the catalogue decides afterwards whether anyone sees them.
  WorkFolder placed(context.dir.Revision(lease.flight_id, *number));
  if (rename(made.c_str(), placed.path().c_str()) != 0) return OsError("rename " + made.string(), errno);
  SKYQUILT_TRY(Sync(context.dir.Flight(lease.flight_id), O_DIRECTORY));
  revision.revision = *number;
  Result<bool> published = context.queue.Publish(lease, revision, storage::Now());
  if (!published || !*published) return published;
  placed.Keep();
  RemoveRetired(context, lease.flight_id, before);
  storage::SweepPreviews(context.dir, lease.flight_id, "");
  return true;
}

// Trouble of the machine may pass; trouble with the input will not.
bool MayRetry(ErrorCode code) {
  return code == ErrorCode::kIo || code == ErrorCode::kUnavailable || code == ErrorCode::kInternal ||
         code == ErrorCode::kTimeout;
}

// What the jobs before took says how long this one will; nothing before the first one. Costs are a comfort: a
// job goes on without them.
std::optional<storage::Expectation> Expect(WorkerContext& context, const storage::Lease& lease) {
  constexpr int kJobsToGoBy = 30;
  const Result<std::vector<storage::JobCost>> costs = context.costs.Latest(kJobsToGoBy);
  const Result<storage::Flight> flight = context.catalogue.GetFlight(lease.flight_id);
  if (!costs || !flight) return std::nullopt;
  std::optional<storage::Expectation> expectation =
      storage::ExpectationFrom(*costs, static_cast<int>(flight->file_count));
  if (expectation) {
    const Result<LeaseState> state = context.queue.Expect(lease, *expectation);
    if (!state) LogFailure(lease.job_id, "expect", state.error().detail);
  }
  return expectation;
}

void KeepCost(WorkerContext& context, const storage::Lease& lease, const StitchOutcome& outcome) {
  const storage::JobCost cost{lease.job_id, outcome.figures.photos_total, outcome.stages_s};
  const Result<void> kept = context.costs.Add(cost);
  if (!kept) LogFailure(lease.job_id, "cost", kept.error().detail);
}

// The end of a job must reach the queue, even when the database is busy or the disk was full a moment ago.
template <typename Tell>
void TellUntilHeard(const storage::Lease& lease, Tell tell) {
  constexpr int kTries = 5;
  for (int attempt = 1; attempt <= kTries; ++attempt) {
    const Result<bool> written = tell();
    if (written) return;
    LogFailure(lease.job_id, "queue", written.error().detail);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  // Not heard: the lease runs out, and the queue hands the job to the next attempt.
}

}  // namespace

void RunJob(WorkerContext& context, const storage::Lease& lease) {
  LogEvent(
      fmt::format("job {} of flight {} begins (attempt {})", lease.job_id, lease.flight_id, lease.attempt));
  std::optional<Error> failure;
  LeaseState state = LeaseState::kHeld;
  {
    AdoptEarlierAttempt(context.dir.Work(), lease);
    WorkFolder work(context.dir.Work() / storage::WorkName(lease));
    const std::optional<storage::Expectation> expectation = Expect(context, lease);
    JobProgress progress(context.queue, lease, context.is_stopping,
                         expectation ? SharesOf(*expectation) : UsualShares());
    try {
      const StitchedApart made = Stitch(context, lease, work.path(), progress);
      if (!made.outcome) failure = made.outcome.error();
      if (made.outcome && !progress.IsCancelled()) {
        const Result<bool> published = Publish(context, lease, work.path(), made.outcome->figures);
        if (!published) failure = published.error();
        if (published && *published) KeepCost(context, lease, *made.outcome);
        if (published) {
          LogEvent(fmt::format("job {} {}", lease.job_id, *published ? "is published" : "lost its lease"));
          return;
        }
      }
      // The next attempt goes on from there; the last one's is swept.
      if (made.has_died && !progress.IsCancelled() && lease.attempt < storage::kMaxAttempts) work.Keep();
    } catch (const std::exception& thrown) {
      failure = Error{ErrorCode::kInternal, "The worker ran out of memory or another means. It tries again.",
                      thrown.what()};
    }
    state = progress.lease_state();
  }
  if (state == LeaseState::kLost) {
    LogEvent(fmt::format("job {} lost its lease", lease.job_id));
  } else if (state == LeaseState::kCancelRequested) {
    TellUntilHeard(lease, [&] { return context.queue.Dismiss(lease, storage::Now()); });
    LogEvent(fmt::format("job {} is cancelled", lease.job_id));
  } else if (context.is_stopping) {
    TellUntilHeard(lease, [&] { return context.queue.GiveBack(lease, storage::Now()); });
  } else if (failure) {
    LogFailure(lease.job_id, "job", failure->message + " " + failure->detail);
    TellUntilHeard(
        lease, [&] { return context.queue.Fail(lease, *failure, MayRetry(failure->code), storage::Now()); });
  }
}

}  // namespace skyquilt::server
