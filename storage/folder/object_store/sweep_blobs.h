// SweepBlobs: puts the place of photos and maps in order after crashes, where that is not the data folder
// (Sweep looks after the folder). Removed is only what is known to be nobody's: blobs of flights whose
// deletion was begun ("deleted/<flight>" says so for a day, in which workers that had not heard of it may put
// more), revisions that no flight shows, and parts of large flights whose jobs have ended. Files that are no
// file of their flight move to lost/<day>/. Blobs of flights that the catalogue does not know stay where they
// are, and are told of: the catalogue may be an older one. So do all blobs of a flight with a map whose
// number the catalogue never gave out. Nothing younger than a day by the store's own clock is touched, so
// that no clock of ours and no upload under way on another machine matters. Any process; several at once do
// no harm. Errors: those of blobs and catalogue.
#pragma once

#include <chrono>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/folder/sweep.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::storage {

inline constexpr std::chrono::hours kOrphanAge{24};

Result<SweepReport> SweepBlobs(BlobStore& blobs, const Catalogue& catalogue, const JobQueue& queue, Time now,
                               std::chrono::seconds orphan_age = kOrphanAge);

// Revisions of one flight that were never shown, or are no longer: at any age. The caller holds the lease of
// the flight's only job. How many blobs went. kConflict where one has a number that was never given out: a
// newer catalogue made it, and the job would make another under its name.
Result<int> SweepRevisionBlobs(BlobStore& blobs, const Catalogue& catalogue, const std::string& flight_id);

}  // namespace skyquilt::storage
