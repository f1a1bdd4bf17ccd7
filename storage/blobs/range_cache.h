// RangeCache: ranges of blobs that lie elsewhere, read in chunks that are kept in the local cache, so that
// what lies near is there already: neighbouring tiles of a map come in one read. Chunks that are missing side
// by side are read at once. Any thread. Errors: those of reading and of the cache.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/local_cache.h"

namespace skyquilt::storage {

inline constexpr std::int64_t kRangeChunkBytes = std::int64_t{256} << 10;

class RangeCache {
 public:
  using Read =
      std::function<Result<std::string>(const std::string& key, std::int64_t offset, std::int64_t length)>;
  RangeCache(LocalCache& cache, Read read) : cache_(cache), read_(std::move(read)) {}

  // Fewer bytes only at the blob's end.
  Result<std::string> Get(const std::string& key, std::int64_t offset, std::int64_t length);
  void Forget(const std::string& key) { cache_.ForgetBelow(key + kFolder); }

 private:
  static constexpr const char* kFolder = ".ranges/";
  static std::string ChunkKey(const std::string& key, std::int64_t chunk);
  // From the cache alone; kNotFound.
  Result<std::string> Kept(const std::string& key, std::int64_t chunk, std::int64_t from, std::int64_t until);
  Result<void> Fetch(const std::string& key, std::int64_t first_chunk, std::int64_t last_chunk);

  LocalCache& cache_;
  const Read read_;
};

}  // namespace skyquilt::storage
