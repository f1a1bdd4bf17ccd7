// S3Blobs: blobs as objects of S3, fetched to this machine where a file is wanted (LocalCache). Files of
// more than kSinglePutBytes go up in parts side by side; every object keeps the SHA-256 of its bytes, against
// which it is held when it is fetched whole; files of tiles, read by ranges, keep one for each chunk beside
// them ("ranges/mosaic.sums", "ranges/mosaic.mbtiles.sums"). Any thread. Errors: those of S3Client and
// LocalCache.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "storage/blobs/blob_store.h"
#include "storage/blobs/local_cache.h"
#include "storage/blobs/lru_memory.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/s3/s3_client.h"

namespace skyquilt::storage {

inline constexpr std::int64_t kSinglePutBytes = std::int64_t{16} << 20;

// How large the parts of an upload of so many bytes are: ten thousand of them suffice for any.
std::int64_t PartBytesFor(std::int64_t bytes);

class S3Blobs final : public BlobStore {
 public:
  S3Blobs(std::unique_ptr<S3Client> client, std::unique_ptr<LocalCache> cache, ProofOfBlob proof = {})
      : client_(std::move(client)),
        cache_(std::move(cache)),
        proof_(std::move(proof)),
        ranges_(
            *cache_,
            [this](const std::string& key, std::int64_t offset, std::int64_t length) {
              return client_->Get(key, offset, length);
            },
            [this](const std::string& key) { return SumsOf(key); }) {}

  Result<void> Put(const std::string& key, const std::filesystem::path& file) override;
  Result<void> PutIfAbsent(const std::string& key, std::string_view bytes) override;
  Result<std::string> ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) override;
  Result<std::string> ReadNear(const std::string& key, std::int64_t offset, std::int64_t length) override {
    return ranges_.Get(key, offset, length);
  }
  void DoubtNear(const std::string& key) override;
  Result<BlobInfo> Find(const std::string& key) override;
  Result<std::optional<std::string>> KnownSum(const std::string& key) override;
  Result<std::vector<BlobInfo>> List(const std::string& prefix) override;
  Result<void> Remove(const std::string& key) override;
  Result<void> Copy(const std::string& from, const std::string& to) override {
    return client_->Copy(from, to);
  }
  Result<int> RemoveBelow(const std::string& prefix) override;
  Result<LocalBlob> Local(const std::string& key) override;
  bool IsFolder() const override { return false; }
  std::filesystem::path FolderOf(const std::string& prefix) const override { return cache_->root() / prefix; }
  std::string Address() const override { return client_->settings().Address(); }

 private:
  Error NotAsPublished(const std::string& key, ErrorCode code) const;
  Result<void> PutInParts(const std::string& key, const std::filesystem::path& file, std::int64_t bytes,
                          const std::string& sha256);
  // Of the chunks of a blob that is read by ranges, 64 bytes for 256 KiB; null for one of a version that put
  // none.
  Result<std::shared_ptr<const std::string>> SumsOf(const std::string& key);
  std::unique_ptr<S3Client> client_;
  std::unique_ptr<LocalCache> cache_;
  const ProofOfBlob proof_;
  RangeCache ranges_;
  static constexpr std::size_t kSumsBytes = std::size_t{16} << 20;  // of maps of 64 GB
  LruMemory<std::string> sums_{kSumsBytes};  // of those asked for lately; empty where there are none
};

}  // namespace skyquilt::storage
