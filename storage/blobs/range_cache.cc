#include "storage/blobs/range_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

Result<void> WriteChunk(const std::filesystem::path& to, std::string_view bytes) {
  std::ofstream file(to, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    return Error{ErrorCode::kOutOfSpace, "The server's disk has no room for its cache.", to.string()};
  return {};
}

// The n-th chunk of bytes that begin with one; empty behind their end.
std::string_view ChunkIn(std::string_view bytes, std::int64_t n) {
  const auto begin = static_cast<std::size_t>(n * kRangeChunkBytes);
  return begin < bytes.size() ? bytes.substr(begin, kRangeChunkBytes) : std::string_view();
}

constexpr std::size_t kSumLength = 64;

bool AreAsPut(const std::string& sums, std::int64_t first_chunk, std::int64_t last_chunk,
              std::string_view bytes) {
  for (std::int64_t chunk = first_chunk; chunk <= last_chunk; ++chunk) {
    const std::string_view part = ChunkIn(bytes, chunk - first_chunk);
    const std::size_t at = static_cast<std::size_t>(chunk) * kSumLength;
    if (at >= sums.size() ? !part.empty() : sums.compare(at, kSumLength, Sha256Hex(part)) != 0) return false;
  }
  return true;
}

}  // namespace

bool IsReadByRanges(std::string_view key) {
  const std::string_view name = key.substr(key.rfind('/') + 1);
  return name == "mosaic.pmtiles" || name == "mosaic.mbtiles";  // nobody reads exports so
}

std::string RangeSumsKey(const std::string& key) {
  const std::size_t name = key.rfind('/') + 1;
  // Those of versions before, which put them beside archives alone, are named so.
  const std::size_t end = key.ends_with(".pmtiles") ? key.rfind('.') : key.size();
  return key.substr(0, name) + "ranges/" + key.substr(name, end - name) + ".sums";
}

Result<std::string> RangeSumsOfFile(const std::filesystem::path& file, Sha256Sum* whole) {
  std::ifstream in(file, std::ios::binary);
  std::string sums, chunk(static_cast<std::size_t>(kRangeChunkBytes), '\0');
  while (in.read(chunk.data(), kRangeChunkBytes) || in.gcount() > 0) {
    const std::string_view bytes(chunk.data(), static_cast<std::size_t>(in.gcount()));
    sums += Sha256Hex(bytes);
    if (whole != nullptr) whole->Add(bytes);
  }
  if (!in.eof() || in.bad())
    return Error{ErrorCode::kIo, "The server could not read a file that it stores.", file.string()};
  return sums;
}

std::string RangeCache::ChunkKey(const std::string& key, std::int64_t chunk) {
  return fmt::format("{}{}{:08}", key, kFolder, chunk);
}

Result<std::string> RangeCache::Kept(const std::string& key, std::int64_t chunk, std::int64_t from,
                                     std::int64_t until) {
  SKYQUILT_TRY_ASSIGN(const LocalBlob kept, cache_.Find(ChunkKey(key, chunk)));
  SKYQUILT_TRY_ASSIGN(std::string slice, ReadRangeOfFile(kept.path, from, until - from));
  if (slice.size() == static_cast<std::size_t>(until - from)) return slice;
  // The blob's last chunk, or one of which a power cut left a part.
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const std::string> sums, sums_(key));
  SKYQUILT_TRY_ASSIGN(const std::string whole, ReadRangeOfFile(kept.path, 0, kRangeChunkBytes));
  if (sums == nullptr || AreAsPut(*sums, chunk, chunk, whole)) return slice;
  cache_.Forget(ChunkKey(key, chunk));
  return Error{ErrorCode::kNotFound, "A chunk in the cache was cut off.", key};
}

Result<std::string> RangeCache::ReadChunks(const std::string& key, std::int64_t first_chunk,
                                           std::int64_t last_chunk) {
  constexpr int kReads = 4;
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const std::string> sums, sums_(key));
  const std::int64_t offset = first_chunk * kRangeChunkBytes;
  const std::int64_t length = (last_chunk - first_chunk + 1) * kRangeChunkBytes;
  for (int reads = 0; reads < kReads; ++reads) {
    Result<std::string> bytes = read_(key, offset, length);
    if (!bytes && bytes.error().code != ErrorCode::kCorrupt) return bytes.error();
    if (bytes && (sums == nullptr || AreAsPut(*sums, first_chunk, last_chunk, *bytes))) return bytes;
  }
  return Error{ErrorCode::kUnavailable,
               "The store of photos and maps gives other bytes than were put there. Try again later.", key};
}

// Into the cache.
Result<void> RangeCache::Fetch(const std::string& key, std::int64_t first_chunk, std::int64_t last_chunk) {
  if (first_chunk == last_chunk) {
    // One of those who want the same chunk reads it; the others wait for that.
    const auto fetch = [&](const std::filesystem::path& to) -> Result<void> {
      SKYQUILT_TRY_ASSIGN(const std::string bytes, ReadChunks(key, first_chunk, first_chunk));
      return WriteChunk(to, bytes);
    };
    SKYQUILT_TRY(cache_.Get(ChunkKey(key, first_chunk), fetch));
    return {};
  }
  SKYQUILT_TRY_ASSIGN(const std::string bytes, ReadChunks(key, first_chunk, last_chunk));
  for (std::int64_t chunk = first_chunk; chunk <= last_chunk; ++chunk) {
    const std::string_view part = ChunkIn(bytes, chunk - first_chunk);
    SKYQUILT_TRY(cache_.Get(ChunkKey(key, chunk),
                            [&](const std::filesystem::path& to) { return WriteChunk(to, part); }));
  }
  return {};
}

Result<std::string> RangeCache::Get(const std::string& key, std::int64_t offset, std::int64_t length) {
  if (length <= 0) return std::string();
  const std::int64_t end = offset + length;
  const std::int64_t first = offset / kRangeChunkBytes;
  const std::int64_t last = (end - 1) / kRangeChunkBytes;
  std::string all;
  std::int64_t missing = -1;  // the first of those that are missing side by side
  // The part of a chunk that is wanted.
  const auto slice = [&](std::int64_t chunk) {
    const std::int64_t begin = chunk * kRangeChunkBytes;
    return Kept(key, chunk, std::max<std::int64_t>(0, offset - begin),
                std::min(kRangeChunkBytes, end - begin));
  };
  const auto fetch_missing = [&](std::int64_t until) -> Result<void> {
    if (missing < 0) return {};
    SKYQUILT_TRY(Fetch(key, missing, until));
    for (std::int64_t chunk = std::exchange(missing, -1); chunk <= until; ++chunk) {
      Result<std::string> bytes = slice(chunk);
      if (!bytes) {
        // What another pushes out of the cache at this very moment is read past it.
        SKYQUILT_TRY_ASSIGN(const std::string whole, ReadChunks(key, chunk, chunk));
        const std::int64_t begin = std::max<std::int64_t>(0, offset - chunk * kRangeChunkBytes);
        const auto behind =
            std::min<std::int64_t>(end - chunk * kRangeChunkBytes, static_cast<std::int64_t>(whole.size()));
        bytes = begin < behind
                    ? whole.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(behind - begin))
                    : std::string();
      }
      if (!bytes) return bytes.error();
      all += *bytes;
    }
    return {};
  };
  for (std::int64_t chunk = first; chunk <= last; ++chunk) {
    const Result<std::string> bytes = slice(chunk);
    if (!bytes && bytes.error().code != ErrorCode::kNotFound) return bytes.error();
    if (!bytes && missing < 0) missing = chunk;
    if (!bytes) continue;
    SKYQUILT_TRY(fetch_missing(chunk - 1));
    all += *bytes;
  }
  SKYQUILT_TRY(fetch_missing(last));
  return all;
}

}  // namespace skyquilt::storage
