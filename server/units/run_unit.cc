#include "server/units/run_unit.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/progress.h"
#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/background_thread.h"
#include "server/jobs/job_task.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/routing/request_log.h"
#include "server/units/cut_job.h"
#include "server/units/end_of_work.h"

namespace skyquilt::server {
namespace {

using storage::LeaseState;

// So that a cancelled job does not keep its workers for long.
constexpr std::chrono::seconds kRenewUnitEvery{2};

// The Progress of a unit: renews the lease and notices cancellation, a lost lease and the end of the worker.
// How far the unit is, nobody asks: its job counts the units that are done. A thread of its own waits for the
// database. Any thread may report.
class UnitHeartbeat final : public Progress {
 public:
  // Both outlive it. Not heard for UnheardTime, it takes its lease for lost.
  UnitHeartbeat(const WorkerContext& context, const storage::UnitLease& lease)
      : context_(context), lease_(lease), thread_([this] { Beat(); }) {}

  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view) override {}
  bool IsCancelled() const override { return context_.is_stopping || state_ != LeaseState::kHeld; }

  LeaseState lease_state() const { return state_; }

 private:
  void Beat() {
    auto renewed = std::chrono::steady_clock::now();
    while (thread_.Rest(kRenewUnitEvery)) {
      const auto now = std::chrono::steady_clock::now();
      const Result<LeaseState> state = context_.units.Renew(lease_, storage::Now());
      if (state) {
        renewed = now;
        if (*state != LeaseState::kHeld) state_ = *state;
      } else {
        // A busy or full database is no reason to stop, until the unit may have gone to another.
        LogFailure(lease_.job_id, "heartbeat", state.error());
        if (now - renewed >= UnheardTime(context_)) state_ = LeaseState::kLost;
      }
    }
  }

  const WorkerContext& context_;
  const storage::UnitLease& lease_;
  std::atomic<LeaseState> state_ = LeaseState::kHeld;
  BackgroundThread thread_;
};

Result<UnitKind> KindOf(const storage::UnitLease& unit) {
  for (const UnitKind kind : {UnitKind::kLook, UnitKind::kRender}) {
    if (unit.kind == UnitKindName(kind)) return kind;
  }
  return Error{ErrorCode::kConflict,
               "This part of a flight is of a kind that this version of Skyquilt does not know.", unit.kind};
}

Result<void> Make(const WorkerContext& context, const storage::UnitLease& unit, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const UnitKind kind, KindOf(unit));
  SKYQUILT_TRY(context.units.MakeAs(unit.job_id, SKYQUILT_VERSION));
  const bool looks = kind == UnitKind::kLook;
  ShareOfFiles share{unit.number, unit.count};
  PartsHere placed;
  if (!looks) {
    SKYQUILT_TRY_ASSIGN(placed,
                        FetchParts(context, unit.flight_id, unit.units_of, UnitKind::kPlace, progress));
    SKYQUILT_TRY_ASSIGN(share, ShownIn(placed, unit));
  }
  SKYQUILT_TRY_ASSIGN(LimitedTask made, TaskOf(context, unit.flight_id, unit.options, share, progress));
  UseParts(std::move(placed), made);
  SKYQUILT_TRY_ASSIGN(auto folder, MakeOutFolder(context, unit.units_of, kind, unit.number));
  ScopedFolder out(std::move(folder));
  made.task.out_dir = out.path();
  made.task.unit = UnitToDo{kind, unit.number, unit.count, looks ? 0 : unit.items};
  const StitchedInSandbox done = StitchSandboxed(std::move(made.task), made.limits, progress);
  // The next attempt goes on from there; after a stop, where no other machine has it by then.
  if (done.has_died || (context.is_stopping && !context.is_shared)) out.Keep();
  if (!done.outcome) return done.outcome.error();
  return HandIn(context, unit.flight_id, unit.units_of, kind, unit.number, out.path(), progress);
}

std::optional<Error> Work(const WorkerContext& context, const storage::UnitLease& unit, Progress& progress) {
  try {
    const Result<void> made = Make(context, unit, progress);
    if (!made) return made.error();
    return std::nullopt;
  } catch (const std::exception& thrown) {
    return flight::Because(ErrorCode::kInternal, flight::RemarkCode::kFailWorkerMeans, thrown.what());
  }
}

void GiveBack(WorkerContext& context, const storage::UnitLease& unit) {
  TellUntilHeard(context, unit.job_id, [&] { return context.units.GiveBack(unit, storage::Now()); });
}

}  // namespace

void RunUnit(WorkerContext& context, const storage::UnitLease& unit) {
  const std::string name = fmt::format("{} {} of {}", unit.kind, unit.number + 1, unit.count);
  LogEvent(fmt::format("job {} of flight {}: {} begins", unit.job_id, unit.flight_id, name));
  std::optional<Error> failure;
  LeaseState state = LeaseState::kHeld;
  {
    UnitHeartbeat heartbeat(context, unit);
    failure = Work(context, unit, heartbeat);
    state = heartbeat.lease_state();
  }
  if (state != LeaseState::kHeld) {
    LogEvent(fmt::format("job {}: {} is cancelled or lost its lease", unit.job_id, name));
    if (context.is_shared) GiveBack(context, unit);  // where it was not heard for long, and nobody took it
  } else if (failure && (context.is_stopping || IsGivenBack(context, context.units, unit, *failure))) {
    GiveBack(context, unit);
  } else if (failure) {
    LogFailure(unit.job_id, name, *failure);
    TellUntilHeard(context, unit.job_id, [&] {
      return context.units.Fail(unit, *failure, MayRetry(context, failure->code), storage::Now());
    });
  } else {
    TellUntilHeard(context, unit.job_id, [&] { return context.units.Done(unit); });
  }
}

}  // namespace skyquilt::server
