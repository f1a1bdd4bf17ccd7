#include "storage/blobs/blob_store.h"

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

Result<std::chrono::system_clock::time_point> TimeOfStore(BlobStore& blobs) {
  const std::string key = "clock/" + NewId();
  SKYQUILT_TRY(blobs.PutIfAbsent(key, "now"));
  const Result<BlobInfo> put = blobs.Find(key);
  SKYQUILT_TRY(blobs.Remove(key));
  if (!put) return put.error();
  return put->changed;
}

Result<void> RemoveFlightBlobs(BlobStore& blobs, const std::string& flight_id) {
  const std::string marker = std::string(kDeletedPrefix) + flight_id;
  const Result<void> marked = blobs.PutIfAbsent(marker, "deleted");
  if (!marked && marked.error().code != ErrorCode::kConflict) return marked.error();
  SKYQUILT_TRY(blobs.RemoveBelow(FlightPrefix(flight_id)));
  return {};
}

}  // namespace skyquilt::storage
