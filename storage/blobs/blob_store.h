// BlobStore: where photos, maps and their states lie: in the data folder (FolderBlobs) or in a store of
// objects (S3Blobs). A blob is known by its key, the path that it has below a data folder:
//   flights/<id>/files/<ours>          an uploaded file
//   flights/<id>/r<revision>/<name>    a product of a map
// A blob under such a key never changes: it is put once and removed once, so that what was fetched of it
// stays right. It is there whole or not at all. Any thread. Errors: kNotFound; kUnavailable (the store is
// away: try again later); kForbidden; kOutOfSpace; kConflict; kCorrupt; kIo.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

struct BlobInfo {
  std::string key;
  std::int64_t bytes = 0;
  std::chrono::system_clock::time_point changed;  // by the store's clock
};

// A blob as a file of this machine. The file stays under its path for as long as `in_use` lives; opened, it
// can be read to the end in any case.
struct LocalBlob {
  std::filesystem::path path;
  std::shared_ptr<const void> in_use;
};

// What reads a blob as a file keeps that file under its path for as long as it lives.
template <typename Reader>
std::shared_ptr<Reader> KeepingFile(std::shared_ptr<Reader> reader, const LocalBlob& file) {
  Reader* const shown = reader.get();
  return {shown, [reader = std::move(reader), in_use = file.in_use](Reader*) mutable { reader.reset(); }};
}

// The SHA-256 (in hex) that a blob is known to have by another than its store; nothing where nobody knows.
using ProofOfBlob = std::function<Result<std::optional<std::string>>(const std::string& key)>;

class BlobStore {
 public:
  virtual ~BlobStore() = default;

  // A copy of a file, durable when this returns.
  virtual Result<void> Put(const std::string& key, const std::filesystem::path& file) = 0;
  // A few bytes, unless there is a blob of this key: kConflict then.
  virtual Result<void> PutIfAbsent(const std::string& key, std::string_view bytes) = 0;
  // Fewer bytes only at the blob's end.
  virtual Result<std::string> ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) = 0;
  // The same, for reads that come again and go on near by: where the blob is far away, its surroundings come
  // along and are kept.
  virtual Result<std::string> ReadNear(const std::string& key, std::int64_t offset, std::int64_t length) = 0;
  // What ReadNear gave makes no sense: what was kept of it without a proof is read anew by the next who asks.
  virtual void DoubtNear(const std::string&) {}
  virtual Result<BlobInfo> Find(const std::string& key) = 0;
  // As ProofOfBlob says. What Local and ReadNear give is held against it, what ReadRange gives is not.
  virtual Result<std::optional<std::string>> KnownSum(const std::string&) {
    return std::optional<std::string>();
  }
  // All blobs whose keys begin so, in the order of their keys.
  virtual Result<std::vector<BlobInfo>> List(const std::string& prefix) = 0;
  // Good also where there was none.
  virtual Result<void> Remove(const std::string& key) = 0;
  // A second blob of the same bytes, made where the first one is.
  virtual Result<void> Copy(const std::string& from, const std::string& to) = 0;
  // All below "a/b/"; how many there were.
  virtual Result<int> RemoveBelow(const std::string& prefix) = 0;
  // As a file: the blob itself, or fetched into this machine's cache.
  virtual Result<LocalBlob> Local(const std::string& key) = 0;

  // True: blobs are files of the data folder, under FolderOf.
  virtual bool IsFolder() const = 0;
  // The folder in which blobs of a prefix "a/b/" lie, or to which they are fetched.
  virtual std::filesystem::path FolderOf(const std::string& prefix) const = 0;
  // Where it is, for people; no secret.
  virtual std::string Address() const = 0;
};

// Aborts on what is no key: one that leads elsewhere, or could not be a path.
void RequireKey(std::string_view key);

// "deleted/<flight>" says that a deletion was begun.
inline constexpr std::string_view kDeletedPrefix = "deleted/";

// What time it is where the blobs are: a small one is put and looked at.
Result<std::chrono::system_clock::time_point> TimeOfStore(BlobStore& blobs);

// Before the catalogue forgets a flight: what is there of it, SweepBlobs removes then, whatever comes
// between. False: it was said before.
Result<bool> MarkDeleted(BlobStore& blobs, const std::string& flight_id);

// All blobs of a flight that the catalogue no longer knows; any process, several at once do no harm. What
// fails, is cut off or comes later, SweepBlobs ends.
Result<void> RemoveFlightBlobs(BlobStore& blobs, const std::string& flight_id);

}  // namespace skyquilt::storage
