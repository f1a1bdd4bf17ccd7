// What is done to a flight's blobs as a whole, and by which clock. Any thread; any process; several at once
// do no harm. Errors: those of the blobs.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"

namespace skyquilt::storage {

// "deleted/<flight>" says that a deletion was begun.
inline constexpr std::string_view kDeletedPrefix = "deleted/";

// What time it is where the blobs are: a small one is put and looked at.
Result<std::chrono::system_clock::time_point> TimeOfStore(BlobStore& blobs);

// All blobs of a flight that the catalogue no longer knows. What fails, is cut off or comes later, SweepBlobs
// ends.
Result<void> RemoveFlightBlobs(BlobStore& blobs, const std::string& flight_id);

}  // namespace skyquilt::storage
