// Sweep: puts a data folder in order after a crash. Removed is only what this server itself wrote as
// temporary and what says so: names with the folder's own id below incoming/ and work/, work folders of jobs
// that the catalogue knows to have ended, previews that are drawn anew. All else that the catalogue does not
// know moves to lost/ (LostFolder), with a line for the log each. Run once at the start of a server, before
// it takes requests, by the one process that holds the DataDirLock. Never touches what the catalogue refers
// to, nor the folders of a live lease.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/previews.h"
#include "storage/files/data_dir.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/map_exports.h"

namespace skyquilt::storage {

struct SweepReport {
  int removed = 0;                 // temporary files and folders
  std::vector<std::string> moved;  // a line for each thing that went to lost/

  void Add(SweepReport other) {
    removed += other.removed;
    moved.insert(moved.end(), other.moved.begin(), other.moved.end());
  }
};

Result<SweepReport> Sweep(const DataDir& dir, const Catalogue& catalogue, const JobQueue& queue,
                          const Previews& previews, Time now);

// The parts of it that are also right while the server runs: work folders without a live lease (a worker
// died), and revisions of one flight that were never shown (the caller holds the lease of the flight's only
// job).
Result<SweepReport> SweepWork(const DataDir& dir, const JobQueue& queue, Time now);
Result<SweepReport> SweepRevisions(const DataDir& dir, const Catalogue& catalogue,
                                   const std::string& flight_id, Time now);
// Preview folders of a flight but the one to keep. Right at any time for a flight that has its map, when none
// is kept.
int SweepPreviews(const DataDir& dir, const std::string& flight_id, const std::string& keep);

// Files of exports that the catalogue does not know, as after a restore from a backup or a crash between a
// file and its row. In the data folder they move to lost/, run as Sweep is: a line for the log for each.
Result<std::vector<std::string>> SweepExports(const DataDir& dir, const Catalogue& catalogue,
                                              const MapExports& exports, Time now);
// Elsewhere they are removed when they are older than `orphan_age` by the store's clock, where they are
// called as exports are: one can be made again. How many were.
Result<int> SweepExportBlobs(BlobStore& blobs, const Catalogue& catalogue, const MapExports& exports,
                             std::chrono::seconds orphan_age);

}  // namespace skyquilt::storage
