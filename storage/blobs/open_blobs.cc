#include "storage/blobs/open_blobs.h"

#include <utility>

#include "core/base/try.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/blobs/s3_blobs.h"

namespace skyquilt::storage {

Result<std::shared_ptr<BlobStore>> OpenBlobs(const BlobPlace& place, const std::filesystem::path& data_folder,
                                             ProofOfBlob proof) {
  if (place.address.empty()) return std::shared_ptr<BlobStore>(std::make_shared<FolderBlobs>(data_folder));
  SKYQUILT_TRY_ASSIGN(S3Settings settings, ReadS3Settings(place.address, EnvironmentVariable));
  auto client = std::make_unique<S3Client>(std::move(settings), EnvironmentVariable);
  SKYQUILT_TRY(client->List("skyquilt-data", ""));
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<LocalCache> cache,
                      LocalCache::Open(data_folder / "cache", place.cache_bytes));
  return std::shared_ptr<BlobStore>(
      std::make_shared<S3Blobs>(std::move(client), std::move(cache), std::move(proof)));
}

}  // namespace skyquilt::storage
