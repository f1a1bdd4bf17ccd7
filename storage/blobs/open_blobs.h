// OpenBlobs: the store that an operator chose: "s3://bucket/prefix", or, where that is empty, the data folder
// itself. Reaches out only to see that the store is there and may be listed. Errors: kInvalidArgument (no
// such address), kUnavailable, kNotFound (no such bucket), kForbidden, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/blobs/local_cache.h"

namespace skyquilt::storage {

struct BlobPlace {
  std::string address;  // empty: the data folder
  std::int64_t cache_bytes = kUsualCacheBytes;
};

// `data_folder`: where the blobs lie, or the cache of those that do not ("cache"). `proof`: what comes out of
// a store is held against it before it is kept; outlives what is opened.
Result<std::shared_ptr<BlobStore>> OpenBlobs(const BlobPlace& place, const std::filesystem::path& data_folder,
                                             ProofOfBlob proof = {});

}  // namespace skyquilt::storage
