#include "storage/blobs/blob_store.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

void RequireKey(std::string_view key) {
  const std::string path = "/" + std::string(key);
  const bool is_key =
      !key.empty() && key.size() <= 900 && !key.ends_with('/') && path.find("//") == std::string::npos &&
      (path + "/").find("/../") == std::string::npos && (path + "/").find("/./") == std::string::npos &&
      std::all_of(key.begin(), key.end(),
                  [](unsigned char c) { return c >= 0x20 && c != 0x7f && c != '\\'; });
  SKYQUILT_CHECK(is_key, "an unchecked name came near a key");
}

Result<std::chrono::system_clock::time_point> TimeOfStore(BlobStore& blobs) {
  const std::string key = "clock/" + NewId();
  SKYQUILT_TRY(blobs.PutIfAbsent(key, "now"));
  const Result<BlobInfo> put = blobs.Find(key);
  SKYQUILT_TRY(blobs.Remove(key));
  if (!put) return put.error();
  return put->changed;
}

Result<bool> MarkDeleted(BlobStore& blobs, const std::string& flight_id) {
  const Result<void> marked = blobs.PutIfAbsent(std::string(kDeletedPrefix) + flight_id, "deleted");
  if (!marked && marked.error().code != ErrorCode::kConflict) return marked.error();
  return marked.ok();
}

Result<void> RemoveFlightBlobs(BlobStore& blobs, const std::string& flight_id) {
  SKYQUILT_TRY(MarkDeleted(blobs, flight_id));
  SKYQUILT_TRY(blobs.RemoveBelow(FlightPrefix(flight_id)));
  return {};
}

}  // namespace skyquilt::storage
