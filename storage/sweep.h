// Sweep: removes what a crash left behind: unfinished uploads, work folders without a live lease, files and
// revisions that the catalogue does not know. Run once at the start of a server, before it takes requests, by
// the one process that holds the DataDirLock. Never touches what the catalogue refers to, nor the folders of
// a live lease.
#pragma once

#include <string>

#include "core/base/result.h"
#include "storage/catalogue.h"
#include "storage/data_dir.h"
#include "storage/job_queue.h"
#include "storage/previews.h"

namespace skyquilt::storage {

struct SweepReport {
  int uploads = 0;
  int work_folders = 0;
  int files = 0;
  int revisions = 0;
  int previews = 0;
  int flights = 0;
};

Result<SweepReport> Sweep(const DataDir& dir, const Catalogue& catalogue, const JobQueue& queue,
                          const Previews& previews, Time now);

// The parts of it that are also right while the server runs: work folders without a live lease (a worker
// died), and revisions of one flight that were never shown (the caller holds the lease of the flight's only
// job).
Result<int> SweepWork(const DataDir& dir, const JobQueue& queue, Time now);
Result<int> SweepRevisions(const DataDir& dir, const Catalogue& catalogue, const std::string& flight_id);
// Preview folders of a flight but the one to keep. Right at any time for a flight that has its map, when none is kept.
int SweepPreviews(const DataDir& dir, const std::string& flight_id, const std::string& keep);

}  // namespace skyquilt::storage
