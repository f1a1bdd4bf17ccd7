#include "server/units/run_unit.h"

#include <fmt/format.h>

#include <exception>
#include <optional>
#include <utility>

#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "server/jobs/job_task.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/routing/request_log.h"
#include "server/units/cut_job.h"
#include "server/units/end_of_work.h"
#include "server/units/unit_heartbeat.h"

namespace skyquilt::server {
namespace {

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
  if (done.has_died) out.Keep();  // the next attempt goes on from there
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
  storage::LeaseState state = storage::LeaseState::kHeld;
  {
    UnitHeartbeat heartbeat(context.units, unit, context.is_stopping, UnheardTime(context));
    failure = Work(context, unit, heartbeat);
    state = heartbeat.lease_state();
  }
  if (state != storage::LeaseState::kHeld) {
    LogEvent(fmt::format("job {}: {} is cancelled or lost its lease", unit.job_id, name));
    if (context.is_shared) GiveBack(context, unit);  // where it was not heard for long, and nobody took it
  } else if (failure && (context.is_stopping || IsGivenBack(context, context.units, unit, *failure))) {
    GiveBack(context, unit);
  } else if (failure) {
    LogFailure(unit.job_id, name, failure->message + " " + failure->detail);
    TellUntilHeard(context, unit.job_id, [&] {
      return context.units.Fail(unit, *failure, MayRetry(context, failure->code), storage::Now());
    });
  } else {
    TellUntilHeard(context, unit.job_id, [&] { return context.units.Done(unit); });
  }
}

}  // namespace skyquilt::server
