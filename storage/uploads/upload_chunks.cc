#include "storage/uploads/upload_chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <set>
#include <utility>

#include "core/base/try.h"
#include "storage/blobs/blob_store.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

constexpr std::string_view kChunkPrefix = "uploads/";

Error DamagedRow() {
  return {ErrorCode::kCorrupt, "The catalogue's row of this upload is damaged. Begin the upload anew.", ""};
}

}  // namespace

std::string NewChunkKey(const std::string& upload_id, std::int64_t offset) {
  return fmt::format("{}{}/{:012}-{}", kChunkPrefix, upload_id, offset, NewId());
}

std::string ChunksText(const std::vector<UploadChunk>& chunks) {
  std::string text;
  for (const UploadChunk& chunk : chunks) text += fmt::format("{}:{};", chunk.key, chunk.bytes);
  return text;
}

Result<std::vector<UploadChunk>> ParseChunks(std::string_view text) {
  std::vector<UploadChunk> chunks;
  while (!text.empty()) {
    const std::size_t colon = text.find(':'), end = text.find(';');
    if (colon == std::string_view::npos || end == std::string_view::npos || colon > end) return DamagedRow();
    UploadChunk chunk{std::string(text.substr(0, colon)), 0};
    const auto read = std::from_chars(text.data() + colon + 1, text.data() + end, chunk.bytes);
    if (read.ec != std::errc() || read.ptr != text.data() + end || chunk.bytes <= 0 ||
        !chunk.key.starts_with(kChunkPrefix))
      return DamagedRow();
    chunks.push_back(std::move(chunk));
    text.remove_prefix(end + 1);
  }
  return chunks;
}

std::string WholeText(const std::string& stored_name) { return "=" + stored_name; }

std::string WholeIn(std::string_view text) {
  return text.starts_with('=') && IsId(text.substr(1)) ? std::string(text.substr(1)) : "";
}

Result<void> JoinChunks(BlobStore& blobs, const std::vector<UploadChunk>& chunks,
                        const std::filesystem::path& to) {
  constexpr std::int64_t kSliceBytes = std::int64_t{8} << 20;
  errno = 0;
  std::ofstream whole(to, std::ios::binary | std::ios::trunc);
  for (const UploadChunk& chunk : chunks) {
    for (std::int64_t at = 0; at < chunk.bytes; at += kSliceBytes) {
      const std::int64_t wanted = std::min(kSliceBytes, chunk.bytes - at);
      SKYQUILT_TRY_ASSIGN(const std::string bytes, blobs.ReadRange(chunk.key, at, wanted));
      if (static_cast<std::int64_t>(bytes.size()) != wanted)
        return Error{ErrorCode::kCorrupt, "A part of the upload is damaged. Begin the upload anew.",
                     chunk.key};
      whole.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
  }
  whole.close();
  if (!whole) return FileError("cannot write", to, errno != 0 ? errno : EIO);
  return {};
}

Result<int> SweepChunks(CatalogueDb& db, BlobStore& blobs, std::chrono::seconds age) {
  SKYQUILT_TRY_ASSIGN(const auto store_time, TimeOfStore(blobs));
  // Listed before the rows are read, so that what comes meanwhile is not in the list.
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> all, blobs.List(std::string(kChunkPrefix)));
  std::set<std::string> listed;
  {
    const auto access = db.Read();
    SKYQUILT_TRY_ASSIGN(Statement query, access->Query("SELECT parts FROM upload WHERE parts<>''"));
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> texts, query.AllText());
    for (const std::string& text : texts) {
      if (!WholeIn(text).empty()) continue;
      SKYQUILT_TRY_ASSIGN(const std::vector<UploadChunk> chunks, ParseChunks(text));
      for (const UploadChunk& chunk : chunks) listed.insert(chunk.key);
    }
  }
  int removed = 0;
  for (const BlobInfo& blob : all) {
    if (listed.contains(blob.key) || store_time - blob.changed < age) continue;
    SKYQUILT_TRY(blobs.Remove(blob.key));
    ++removed;
  }
  return removed;
}

}  // namespace skyquilt::storage
