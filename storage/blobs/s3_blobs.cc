#include "storage/blobs/s3_blobs.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "storage/blobs/sha256.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kPartsSideBySide = 4;
constexpr std::int64_t kMaxParts = 9'000;

// All of the range.
Result<std::string> RangeOf(const fs::path& file, std::int64_t offset, std::int64_t length) {
  SKYQUILT_TRY_ASSIGN(std::string bytes, ReadRangeOfFile(file, offset, length));
  if (static_cast<std::int64_t>(bytes.size()) < length) return FileError("cannot read", file, EIO);
  return bytes;
}

}  // namespace

std::int64_t PartBytesFor(std::int64_t bytes) {
  return std::max(kSinglePutBytes, (bytes + kMaxParts - 1) / kMaxParts);
}

Result<void> S3Blobs::Put(const std::string& key, const fs::path& file) {
  RequireKey(key);
  if (IsReadByRanges(key)) {
    SKYQUILT_TRY_ASSIGN(const std::string sums, RangeSumsOfFile(file));
    SKYQUILT_TRY(client_->Put(RangeSumsKey(key), sums, {Sha256Hex(sums)}));
  }
  SKYQUILT_TRY_ASSIGN(const std::string sha256, Sha256OfFile(file));
  std::error_code error;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(file, error));
  if (error) return FileError("cannot read", file, error.value());
  if (bytes > kSinglePutBytes) return PutInParts(key, file, bytes, sha256);
  SKYQUILT_TRY_ASSIGN(const std::string whole, RangeOf(file, 0, bytes));
  return client_->Put(key, whole, {sha256});
}

Result<void> S3Blobs::PutInParts(const std::string& key, const fs::path& file, std::int64_t bytes,
                                 const std::string& sha256) {
  const std::int64_t part_bytes = PartBytesFor(bytes);
  const auto count = static_cast<std::size_t>((bytes + part_bytes - 1) / part_bytes);
  SKYQUILT_TRY_ASSIGN(const std::string upload_id, client_->BeginUpload(key, {sha256}));
  std::vector<UploadedPart> parts(count);
  Result<void> done = ParallelTry(count, kPartsSideBySide, [&](std::size_t i) -> Result<void> {
    const std::int64_t offset = static_cast<std::int64_t>(i) * part_bytes;
    SKYQUILT_TRY_ASSIGN(const std::string part, RangeOf(file, offset, std::min(part_bytes, bytes - offset)));
    SKYQUILT_TRY_ASSIGN(parts[i], client_->PutPart(key, upload_id, static_cast<int>(i) + 1, part));
    return {};
  });
  if (done) done = client_->Complete(key, upload_id, parts, bytes);
  // What stays, the store's own rule for begun uploads removes.
  if (!done) (void)client_->Abort(key, upload_id).ok();
  return done;
}

Result<void> S3Blobs::PutIfAbsent(const std::string& key, std::string_view bytes) {
  RequireKey(key);
  return client_->Put(key, bytes, {Sha256Hex(bytes), true});
}

Result<std::string> S3Blobs::ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) {
  RequireKey(key);
  if (length == 0) return std::string();
  return client_->Get(key, offset, length);
}

Result<std::shared_ptr<const std::string>> S3Blobs::SumsOf(const std::string& key) {
  std::shared_ptr<const std::string> sums = sums_.Find(key);
  if (sums == nullptr) {
    std::string text;
    const Result<LocalBlob> local = Local(RangeSumsKey(key));
    if (local) {
      SKYQUILT_TRY_ASSIGN(text, ReadWholeFile(local->path));
    } else if (local.error().code == ErrorCode::kCorrupt) {
      return Error{ErrorCode::kUnavailable, local.error().message, local.error().detail};
    } else if (local.error().code != ErrorCode::kNotFound) {
      return local.error();
    } else {
      SKYQUILT_TRY_ASSIGN(const std::optional<std::string> published, KnownSum(RangeSumsKey(key)));
      if (published && !published->empty()) return NotAsPublished(RangeSumsKey(key), ErrorCode::kUnavailable);
    }
    sums = std::make_shared<const std::string>(std::move(text));
    sums_.Keep(key, sums, key.size() + sums->size());
  }
  return sums->empty() ? nullptr : sums;
}

void S3Blobs::DoubtNear(const std::string& key) {
  const auto sums = SumsOf(key);
  if (!sums || *sums == nullptr) ranges_.Forget(key);
}

Result<BlobInfo> S3Blobs::Find(const std::string& key) {
  RequireKey(key);
  SKYQUILT_TRY_ASSIGN(const S3Object object, client_->Head(key));
  return BlobInfo{key, object.bytes, object.changed};
}

Result<std::vector<BlobInfo>> S3Blobs::List(const std::string& prefix) {
  std::vector<BlobInfo> blobs;
  std::string continuation;
  do {
    SKYQUILT_TRY_ASSIGN(const ListedPage page, client_->List(prefix, continuation));
    for (const ListedObject& object : page.objects)
      blobs.push_back({object.key, object.bytes, object.changed});
    continuation = page.next;
  } while (!continuation.empty());
  return blobs;
}

Result<void> S3Blobs::Remove(const std::string& key) {
  RequireKey(key);
  cache_->Forget(key);
  ranges_.Forget(key);
  return client_->Delete(key);
}

Result<int> S3Blobs::RemoveBelow(const std::string& prefix) {
  SKYQUILT_CHECK(prefix.ends_with('/') && prefix.size() > 1, "what is removed as a whole is a folder");
  cache_->ForgetBelow(prefix);
  int removed = 0;
  while (true) {
    // The first page again and again, until it is empty.
    SKYQUILT_TRY_ASSIGN(const ListedPage page, client_->List(prefix, ""));
    if (page.objects.empty()) return removed;
    std::vector<std::string> keys;
    for (const ListedObject& object : page.objects) keys.push_back(object.key);
    SKYQUILT_TRY(client_->DeleteAll(keys));
    removed += static_cast<int>(keys.size());
  }
}

Result<std::optional<std::string>> S3Blobs::KnownSum(const std::string& key) {
  if (!proof_) return std::optional<std::string>();
  return proof_(key);
}

Error S3Blobs::NotAsPublished(const std::string& key, ErrorCode code) const {
  return {
      code,
      "The store of photos and maps has not the file that was published there. Whoever runs the server can "
      "put a good copy back.",
      Address() + key};
}

Result<LocalBlob> S3Blobs::Local(const std::string& key) {
  return cache_->Get(key, [&](const fs::path& to) -> Result<void> {
    SKYQUILT_TRY_ASSIGN(const std::optional<std::string> published, KnownSum(key));
    // A wrong byte may have come on the way: it is read again before the store is believed to have it.
    constexpr int kReads = 3;
    for (int reads = 1;; ++reads) {
      const Result<S3Object> got = client_->GetToFile(key, to);
      if (got && published && got->sha256 != *published) return NotAsPublished(key, ErrorCode::kCorrupt);
      if (got) return {};
      if (got.error().code != ErrorCode::kCorrupt || reads == kReads) return got.error();
    }
  });
}

}  // namespace skyquilt::storage
