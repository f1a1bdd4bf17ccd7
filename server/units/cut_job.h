// CutJob: what the worker that claimed a job is to do with it: make the whole map, or, of a flight so large
// that it is cut, the next step between units. The steps are one after the other: the files are looked at
// (units), the flight is placed (whoever claims the job), ranges of the map are rendered (units), the map is
// put together (whoever claims the job). What units leave for each other lies below work/, or, where photos
// and maps lie elsewhere, beside these. Blocking. Errors: those of the queue, of blobs and of
// StitchSandboxed.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "server/jobs/job_progress.h"
#include "server/jobs/job_task.h"
#include "server/jobs/unit_files.h"
#include "server/jobs/worker_context.h"

namespace skyquilt::server {

enum class CutStep { kWhole, kLook, kPlace, kPutTogether };

struct CutJob {
  CutStep step = CutStep::kWhole;
  int files = 0;              // of the flight
  int looks = 0;              // units that looked
  int renders = 0;            // units that rendered
  std::string units_of = {};  // as storage::UnitQueue::UnitsOf
};

// Of a job whose map is shown.
void RemoveUnits(const WorkerContext& context, const std::string& flight_id, const CutJob& cut);

// Where it cannot be told, nothing is decided: made whole, a flight may be too large for the machine.
Result<CutJob> CutOf(const WorkerContext& context, const storage::Lease& lease);
ProgressSpan ProgressOf(CutStep step);

// The job waits for its units then, but for those that one that failed had made of the same. False: the lease
// was lost.
Result<bool> CutIntoLooks(WorkerContext& context, const storage::Lease& lease, const CutJob& cut);
// Places the flight, unless an attempt before had done so.
Result<bool> PlaceAndCut(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                         Progress& progress);

// What units of a kind left, and those before it, where it is on this machine.
struct PartsHere {
  std::filesystem::path dir;
  FilesInUse in_use;  // what was fetched for it
};
Result<PartsHere> FetchParts(const WorkerContext& context, const std::string& flight_id,
                             const std::string& units_of, UnitKind kind, Progress& progress);
void UseParts(PartsHere parts, LimitedTask& made);
// The photos that a unit that renders may show, by what placing left.
Result<ShareOfFiles> ShownIn(const PartsHere& parts, const storage::UnitLease& unit);
// A folder for what a unit makes, of this attempt alone; what one that died got to is in it.
Result<std::filesystem::path> MakeOutFolder(const WorkerContext& context, const std::string& units_of,
                                            UnitKind kind, int number);
// What was made there is for all workers from now on, whole.
Result<void> HandIn(const WorkerContext& context, const std::string& flight_id, const std::string& units_of,
                    UnitKind kind, int number, const std::filesystem::path& made, Progress& progress);

}  // namespace skyquilt::server
