#include "server/workers/run_job.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <optional>
#include <system_error>
#include <vector>

#include "core/base/process/file_descriptor.h"
#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/inputs/film_frames.h"
#include "server/jobs/job_progress.h"
#include "server/jobs/job_task.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/routing/request_log.h"
#include "server/units/cut_job.h"
#include "server/units/end_of_work.h"
#include "storage/folder/object_store/sweep_blobs.h"
#include "storage/folder/sweep.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;
using storage::LeaseState;

Result<void> Sync(const fs::path& path, int flags) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | flags));
  if (!file.is_open()) return MapNotStored("open " + path.string(), errno);
  if (fsync(file.get()) != 0) return MapNotStored("fsync " + path.string(), errno);
  return {};
}

Result<void> SyncTree(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    std::error_code unknown;  // Sync says what is wrong with it
    SKYQUILT_TRY(entry.is_directory(unknown) ? SyncTree(entry.path()) : Sync(entry.path(), 0));
  }
  if (error) return MapNotStored("list " + folder.string(), error.value());
  return Sync(folder, O_DIRECTORY);
}

// Takes over the folder of a dead attempt of the same job, so that this one goes on where that stopped.
void AdoptEarlierAttempt(const storage::DataDir& dir, const storage::Lease& lease) {
  const fs::path work = dir.Work();
  const fs::path own = work / storage::WorkName(lease);
  std::vector<fs::path> earlier;
  std::error_code none;  // without an earlier attempt this one begins anew
  for (const auto& entry : fs::directory_iterator(work, none)) {
    const std::string name = entry.path().filename().string();
    if (entry.path() != own && !storage::IsUnitsWork(name) && storage::JobOfWorkName(name) == lease.job_id) {
      earlier.push_back(entry.path());
    }
  }
  std::sort(earlier.begin(), earlier.end());
  for (const fs::path& folder : earlier) {
    if (!fs::exists(own, none)) fs::rename(folder, own, none);
    fs::remove_all(folder, none);
  }
}

// What jobs that ended elsewhere left here: a machine of workers alone has no server that sweeps.
void SweepEnded(const WorkerContext& context) {
  const Result<storage::SweepReport> swept = storage::SweepWork(context.dir, context.queue, storage::Now());
  if (!swept) return LogFailure("-", "sweep of work", swept.error());
  for (const std::string& line : swept->moved) LogEvent(line);
}

// The map that the flight shows now; 0 when it has none.
Result<std::int64_t> ShownRevision(const WorkerContext& context, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, context.catalogue.Revisions(flight_id));
  return revisions.empty() ? 0 : *std::max_element(revisions.begin(), revisions.end());
}

// An earlier attempt may have died between placing a revision and showing it.
Result<void> SweepUnshown(const WorkerContext& context, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const storage::SweepReport swept,
                      storage::SweepRevisions(context.dir, context.catalogue, flight_id, storage::Now()));
  for (const std::string& line : swept.moved) LogEvent(line);
  if (context.blobs.IsFolder()) return {};
  SKYQUILT_TRY_ASSIGN(const int removed,
                      storage::SweepRevisionBlobs(context.blobs, context.catalogue, flight_id));
  if (removed > 0)
    LogEvent(fmt::format("{} blobs of maps that flight {} does not show were removed", removed, flight_id));
  return {};
}

// What the task reads beside the files: the map that is shown, where it is on this machine.
Result<void> FetchShown(const WorkerContext& context, const std::string& flight_id, LimitedTask& made,
                        Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::int64_t shown, ShownRevision(context, flight_id));
  if (shown == 0) return {};
  const std::string map = storage::RevisionPrefix(flight_id, shown);
  made.task.previous_dir = context.blobs.FolderOf(map);
  if (context.blobs.IsFolder()) return {};
  SKYQUILT_TRY_ASSIGN(FilesInUse of_map, FetchMap(context.blobs, map, progress));
  if (of_map.size() < 2) made.task.previous_dir.clear();
  made.in_use.insert(made.in_use.end(), of_map.begin(), of_map.end());
  return {};
}

StitchedInSandbox Stitch(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                         const fs::path& out_dir, Progress& progress) {
  std::error_code error;
  fs::create_directory(out_dir, error);  // below work/, which a data folder that is gone does not have
  if (error) return {MapNotStored("make " + out_dir.string(), error.value())};
  const Result<void> swept = SweepUnshown(context, lease.flight_id);
  if (!swept) return {swept.error()};
  Result<LimitedTask> made = TaskOf(context, lease.flight_id, lease.options, {}, progress);
  if (!made) return {made.error()};
  if (KindOf(lease.options) != JobKind::kImport) {
    const Result<void> fetched = FetchShown(context, lease.flight_id, *made, progress);
    if (!fetched) return {fetched.error()};
  }
  made->task.out_dir = out_dir;
  made->task.with_pmtiles = !context.blobs.IsFolder();
  if (cut.step == CutStep::kPutTogether) {
    Result<PartsHere> parts = FetchParts(context, lease.flight_id, cut.units_of, UnitKind::kRender, progress);
    if (!parts) return {parts.error()};
    UseParts(*std::move(parts), *made);
    made->task.renders = cut.renders;
  }
  return StitchSandboxed(std::move(made->task), made->limits, progress);
}

// What a sandboxed process left: plain files with no second name, nothing that leads elsewhere, and one
// folder of such files, the frames of its films.
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
  if (error) return MapNotStored("list " + folder.string(), error.value());
  return {};
}

// What the publish retired. The revision shown before stays for readers who just looked it up.
void RemoveRetired(WorkerContext& context, const std::string& flight_id,
                   const std::vector<std::int64_t>& before) {
  const Result<std::vector<std::int64_t>> after = context.catalogue.Revisions(flight_id);
  if (!after) return;  // the sweep of the next start removes them
  for (const std::int64_t revision : before) {
    if (std::find(after->begin(), after->end(), revision) != after->end()) continue;
    (void)context.blobs.RemoveBelow(storage::RevisionPrefix(flight_id, revision)).ok();  // as above
  }
}

// As Publish below; every product is put in its place before anybody is told.
Result<bool> PublishInObjectStore(WorkerContext& context, const storage::Lease& lease, const fs::path& made,
                                  const storage::Revision& revision, Progress& progress) {
  const std::string prefix = storage::RevisionPrefix(lease.flight_id, revision.revision);
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::MapProduct> products, storage::ProductsIn(made));
  Result<bool> published = false;
  const Result<void> put = PutProducts(context.blobs, made, prefix, progress);
  if (!put) published = put.error();
  if (put) published = context.queue.Publish(lease, revision, storage::Now(), products);
  // Nobody was told. What cannot be removed now, the flight's next job or a sweep removes. Of a catalogue
  // that did not answer it is not known whom it tells.
  const bool is_unshown = !put || (published && !*published);
  if (is_unshown) (void)context.blobs.RemoveBelow(prefix).ok();
  return published;
}

// False: the lease was lost or the job cancelled, and nothing was shown.
Result<bool> Publish(WorkerContext& context, const storage::Lease& lease, const fs::path& made,
                     storage::Revision revision, Progress& progress) {
  SKYQUILT_TRY(CheckProducts(made));
  SKYQUILT_TRY(SyncTree(made));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> before, context.catalogue.Revisions(lease.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::int64_t> number, context.queue.ReserveRevision(lease));
  if (!number) return false;
  revision.revision = *number;
  if (!context.blobs.IsFolder()) {
    SKYQUILT_TRY_ASSIGN(const bool is_shown, PublishInObjectStore(context, lease, made, revision, progress));
    if (is_shown) RemoveRetired(context, lease.flight_id, before);
    if (is_shown) storage::SweepPreviews(context.dir, lease.flight_id, "");
    return is_shown;
  }
  // One rename puts all products in place; the catalogue decides afterwards whether anyone sees them.
  ScopedFolder placed(context.dir.Revision(lease.flight_id, *number));
  if (rename(made.c_str(), placed.path().c_str()) != 0) return MapNotStored("rename " + made.string(), errno);
  SKYQUILT_TRY(Sync(context.dir.Flight(lease.flight_id), O_DIRECTORY));
  Result<bool> published = context.queue.Publish(lease, revision, storage::Now());
  // Whether it is shown is not known then; if not, the next sweep of its flight takes the folder.
  if (!published && published.error().code == ErrorCode::kUnavailable) placed.Keep();
  if (!published || !*published) return published;
  placed.Keep();
  RemoveRetired(context, lease.flight_id, before);
  storage::SweepPreviews(context.dir, lease.flight_id, "");
  return true;
}

// What the jobs before took says how long this one will; nothing before the first one. Costs are a comfort: a
// job goes on without them.
std::optional<storage::Expectation> Expect(WorkerContext& context, const storage::Lease& lease) {
  if (IsMadeWhole(lease.options)) return std::nullopt;  // what was measured is of photos on the smooth ground
  constexpr int kJobsToGoBy = 30;
  const Result<std::vector<storage::JobCost>> costs = context.costs.Latest(kJobsToGoBy);
  const Result<storage::Flight> flight = context.catalogue.GetFlight(lease.flight_id);
  if (!costs || !flight) return std::nullopt;
  std::optional<storage::Expectation> expectation =
      storage::ExpectationFrom(*costs, static_cast<int>(flight->file_count));
  if (expectation) {
    const Result<LeaseState> state = context.queue.Expect(lease, *expectation);
    if (!state) LogFailure(lease.job_id, "expect", state.error());
  }
  return expectation;
}

void KeepCost(WorkerContext& context, const storage::Lease& lease, const StitchOutcome& outcome) {
  if (IsMadeWhole(lease.options)) return;
  const storage::JobCost cost{lease.job_id, outcome.figures.photos_total, outcome.stages_s};
  const Result<void> kept = context.costs.Add(cost);
  if (!kept) LogFailure(lease.job_id, "cost", kept.error());
}

}  // namespace

void RunJob(WorkerContext& context, const storage::Lease& lease) {
  LogEvent(
      fmt::format("job {} of flight {} begins (attempt {})", lease.job_id, lease.flight_id, lease.attempt));
  if (context.is_shared) SweepEnded(context);
  std::optional<Error> failure;
  bool is_unshown = false;  // the map is made, and the catalogue did not take it
  LeaseState state = LeaseState::kHeld;
  {
    const Result<CutJob> found = CutOf(context, lease);
    // The catalogue's trouble, whatever it is, and not the flight's.
    if (!found)
      failure =
          Error{ErrorCode::kUnavailable, found.error().message, found.error().detail, found.error().reason};
    const CutJob cut = found ? *found : CutJob{};
    if (found) AdoptEarlierAttempt(context.dir, lease);
    ScopedFolder work(context.dir.Work() / storage::WorkName(lease));
    const std::optional<storage::Expectation> expectation = Expect(context, lease);
    JobProgress progress(context.queue, lease, context.is_stopping,
                         expectation ? SharesOf(*expectation) : UsualShares(KindOf(lease.options)),
                         ProgressOf(cut.step), UnheardTime(context));
    try {
      if (cut.step == CutStep::kLook || cut.step == CutStep::kPlace) {
        const Result<bool> waits = cut.step == CutStep::kLook ? CutIntoLooks(context, lease, cut)
                                                              : PlaceAndCut(context, lease, cut, progress);
        if (waits) {
          LogEvent(fmt::format("job {} {}", lease.job_id, *waits ? "waits for its parts" : "lost its lease"));
          return;
        }
        failure = waits.error();
      }
      const StitchedInSandbox made =
          failure ? StitchedInSandbox{*failure, false} : Stitch(context, lease, cut, work.path(), progress);
      if (!made.outcome) failure = made.outcome.error();
      if (made.outcome && !progress.IsCancelled()) {
        const Result<bool> published = Publish(context, lease, work.path(), made.outcome->figures, progress);
        if (!published) failure = published.error();
        // A map that could not be put in its place is not rendered again.
        if (!published && !context.blobs.IsFolder() && lease.attempt < storage::kMaxAttempts) work.Keep();
        // What a part of the work took says nothing of a whole job.
        if (published && *published && cut.step == CutStep::kWhole) KeepCost(context, lease, *made.outcome);
        if (published && *published) {
          LogEvent(fmt::format("job {} is published", lease.job_id));
          if (cut.step != CutStep::kWhole) RemoveUnits(context, lease.flight_id, cut);
          return;
        }
        is_unshown = published.ok();
      }
      // The next attempt goes on from there; the last one's is swept. A stop is no attempt, but where
      // machines share the queue another one, as a rule, has the job before this one is started again.
      const bool is_cut_off =
          context.is_stopping ? !context.is_shared : made.has_died && lease.attempt < storage::kMaxAttempts;
      if (is_cut_off && progress.lease_state() == LeaseState::kHeld) work.Keep();
    } catch (const std::exception& thrown) {
      failure = flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailWorkerMeans, thrown.what());
    }
    if (is_unshown) {
      const Result<LeaseState> why = context.queue.LeaseStateOf(lease);
      state = why ? *why : LeaseState::kLost;
    } else {
      state = progress.lease_state();
    }
  }
  const auto give_back = [&] {
    TellUntilHeard(context, lease.job_id, [&] { return context.queue.GiveBack(lease, storage::Now()); });
  };
  if (state == LeaseState::kLost) {
    LogEvent(fmt::format("job {} lost its lease", lease.job_id));
    if (context.is_shared) give_back();  // where it was not heard for long, and nobody took it
  } else if (state == LeaseState::kCancelRequested) {
    TellUntilHeard(context, lease.job_id, [&] { return context.queue.Dismiss(lease, storage::Now()); });
    LogEvent(fmt::format("job {} is cancelled", lease.job_id));
  } else if (context.is_stopping || (failure && IsGivenBack(context, context.queue, lease, *failure))) {
    give_back();
  } else if (failure) {
    LogFailure(lease.job_id, "job", *failure);
    TellUntilHeard(context, lease.job_id, [&] {
      return context.queue.Fail(lease, *failure, MayRetry(context, failure->code), storage::Now());
    });
  }
}

}  // namespace skyquilt::server
