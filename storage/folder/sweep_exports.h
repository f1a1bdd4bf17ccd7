// SweepExports: files of exports that the catalogue does not know, as after a restore from a backup or a
// crash between a file and its row. In the data folder they move to lost/ (LostFolder), once at the start of
// a server, by the one process that holds the DataDirLock. Elsewhere they are removed when they are older
// than `orphan_age` by the store's clock, where they are called as exports are: one can be made again.
// Errors: those of blobs and catalogue.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"
#include "storage/files/data_dir.h"
#include "storage/jobs/map_exports.h"

namespace skyquilt::storage {

// A line for the log for each file that went to lost/.
Result<std::vector<std::string>> SweepExports(const DataDir& dir, const Catalogue& catalogue,
                                              const MapExports& exports, Time now);
// How many were removed.
Result<int> SweepExportBlobs(BlobStore& blobs, const Catalogue& catalogue, const MapExports& exports,
                             std::chrono::seconds orphan_age);

}  // namespace skyquilt::storage
