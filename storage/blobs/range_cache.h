// RangeCache: ranges of blobs that lie elsewhere, read in chunks that are kept in the local cache, so that
// what lies near is there already: neighbouring tiles of a map come in one read. Chunks that are missing side
// by side are read at once. Where the blob was put with the sums of its chunks, each is held against its own
// before it is kept, and read again where it is another. Any thread. Errors: those of reading and of the
// cache; kUnavailable (the store gives other bytes than were put, again and again).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "storage/blobs/local_cache.h"
#include "storage/blobs/sha256.h"

namespace skyquilt::storage {

inline constexpr std::int64_t kRangeChunkBytes = std::int64_t{256} << 10;

// Of the products of maps those that are read by ranges, by their names or keys.
bool IsReadByRanges(std::string_view key);
// SHA-256 of each chunk of a file, in hex, one after the other; and the key under which they are kept beside
// a blob. `whole`: gets all of it in the same read.
Result<std::string> RangeSumsOfFile(const std::filesystem::path& file, Sha256Sum* whole = nullptr);
std::string RangeSumsKey(const std::string& key);

class RangeCache {
 public:
  using Read =
      std::function<Result<std::string>(const std::string& key, std::int64_t offset, std::int64_t length)>;
  // Of a blob's chunks (RangeSumsOfFile); null: there are none.
  using Sums = std::function<Result<std::shared_ptr<const std::string>>(const std::string& key)>;
  RangeCache(LocalCache& cache, Read read, Sums sums)
      : cache_(cache), read_(std::move(read)), sums_(std::move(sums)) {}

  // Fewer bytes only at the blob's end.
  Result<std::string> Get(const std::string& key, std::int64_t offset, std::int64_t length);
  void Forget(const std::string& key) { cache_.ForgetBelow(key + kFolder); }

 private:
  // What versions before kept in ".ranges/" was held against nothing.
  static constexpr const char* kFolder = ".chunks/";
  static std::string ChunkKey(const std::string& key, std::int64_t chunk);
  // From the cache alone; kNotFound.
  Result<std::string> Kept(const std::string& key, std::int64_t chunk, std::int64_t from, std::int64_t until);
  Result<void> Fetch(const std::string& key, std::int64_t first_chunk, std::int64_t last_chunk);
  // What was put, from the store.
  Result<std::string> ReadChunks(const std::string& key, std::int64_t first_chunk, std::int64_t last_chunk);

  LocalCache& cache_;
  const Read read_;
  const Sums sums_;
};

}  // namespace skyquilt::storage
