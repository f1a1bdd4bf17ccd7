// WorkerContext: what a worker process has to work with, for the time of its life. One thread.
#pragma once

#include <atomic>
#include <chrono>
#include <optional>

#include "core/pipeline/units/flight_cut.h"
#include "server/jobs/job_limits.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/files/data_dir.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"

namespace skyquilt::server {

// Flights of more files are cut into units that several workers share.
inline constexpr int kCutAboveFiles = 2000;

struct WorkerContext {
  const storage::DataDir& dir;
  storage::BlobStore& blobs;
  storage::Catalogue& catalogue;
  storage::JobQueue& queue;
  storage::StageCosts& costs;
  storage::UnitQueue& units;
  const std::atomic<bool>& is_stopping;
  GivenLimits limits = {};
  int files_per_unit = static_cast<int>(pipeline::kFilesPerLook);
  int cut_above_files = kCutAboveFiles;  // 0: no job is cut
  bool is_shared = false;                // other machines with files of their own work on the same queue
  std::optional<Error> fault = {};       // of this machine, that the last work was given back for
  bool may_hold = false;                 // the end of what it had was not heard: it is still its own, perhaps
};

// How long a worker goes on whose renewals the catalogue does not hear. Where each has files of its own, who
// works for nothing disturbs nobody, and a database that is away for all gives its work to no other; else
// another may be about to go on in its folder.
inline std::chrono::seconds UnheardTime(const WorkerContext& context) {
  return context.is_shared ? std::chrono::minutes(15) : storage::kLeaseTime;
}

}  // namespace skyquilt::server
