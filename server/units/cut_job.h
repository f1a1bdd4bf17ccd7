// CutJob: what the worker that claimed a job is to do with it: make the whole map, or, of a flight so large
// that it is cut, the next step between units. The steps are one after the other: the files are looked at
// (units), the flight is placed (whoever claims the job), ranges of the map are rendered (units), the map is
// put together (whoever claims the job). What units leave for each other lies below work/, or, where photos
// and maps lie elsewhere, beside these. Blocking. Errors: those of the queue, of blobs and of StitchApart.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "server/jobs/job_progress.h"
#include "server/jobs/job_task.h"
#include "server/jobs/worker_context.h"
#include "server/units/unit_files.h"

namespace skyquilt::server {

enum class CutStep { kWhole, kLook, kPlace, kPutTogether };

struct CutJob {
  CutStep step = CutStep::kWhole;
  int files = 0;    // of the flight
  int looks = 0;    // units that looked
  int renders = 0;  // units that rendered
};

// Below work/, where it is swept once the job has ended.
std::filesystem::path UnitsFolder(const storage::DataDir& dir, const std::string& job_id);
// Of a job that has ended.
void RemoveUnits(const WorkerContext& context, const storage::Lease& lease);

// kWhole also where it cannot be told.
CutJob CutOf(const WorkerContext& context, const storage::Lease& lease);
ProgressSpan ProgressOf(CutStep step);

// The job waits for its units then. False: the lease was lost.
Result<bool> CutIntoLooks(WorkerContext& context, const storage::Lease& lease, const CutJob& cut);
Result<bool> PlaceAndCut(WorkerContext& context, const storage::Lease& lease, const CutJob& cut,
                         Progress& progress);

// What units of a kind left, and those before it, where it is on this machine.
struct PartsHere {
  std::filesystem::path dir;
  FilesInUse in_use;  // what was fetched for it
};
Result<PartsHere> FetchParts(const WorkerContext& context, const storage::Lease& lease, UnitKind kind,
                             Progress& progress);
void UseParts(PartsHere parts, LimitedTask& made);
// The photos that a unit that renders may show, by what placing left.
Result<ShareOfFiles> ShownIn(const PartsHere& parts, const storage::UnitLease& unit);
// The folder into which a unit writes, made.
Result<std::filesystem::path> MakeOutFolder(const WorkerContext& context, const std::string& job_id,
                                            UnitKind kind, int number);
// What a unit wrote there is for all workers from now on.
Result<void> HandIn(const WorkerContext& context, const std::string& flight_id, const std::string& job_id,
                    UnitKind kind, int number, Progress& progress);

}  // namespace skyquilt::server
