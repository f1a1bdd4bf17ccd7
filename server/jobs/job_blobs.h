// What a job needs of blobs that lie elsewhere than in the data folder, and what it leaves there. A store
// that is away is waited for, within bounds, while the job is wanted. Blocking. Errors: kCancelled, and those
// of the blobs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::server {

// The files stay on this machine for as long as this lives.
using FilesInUse = std::vector<storage::LocalBlob>;

// A flight's files into this machine's cache, side by side.
Result<FilesInUse> FetchFiles(storage::BlobStore& blobs, const std::string& flight_id,
                              const std::vector<storage::StoredFile>& files, Progress& progress);
// What the next map takes over from the one that is shown: its tiles and its memory.
Result<FilesInUse> FetchMap(storage::BlobStore& blobs, const std::string& prefix, Progress& progress);

// All blobs whose keys begin so.
Result<FilesInUse> FetchBelow(storage::BlobStore& blobs, const std::string& prefix, Progress& progress);

// All files of a folder and those below, under a prefix. What was put stays if this fails.
Result<void> PutProducts(storage::BlobStore& blobs, const std::filesystem::path& folder,
                         const std::string& prefix, Progress& progress);

}  // namespace skyquilt::server
