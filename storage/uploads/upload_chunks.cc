#include "storage/uploads/upload_chunks.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::storage {
namespace {

constexpr std::string_view kChunkPrefix = "uploads/";

Error DamagedRow() {
  return {ErrorCode::kCorrupt, "The catalogue's row of this upload is damaged. Begin the upload anew.", ""};
}

Error DamagedPart(const std::string& which) {
  return {ErrorCode::kCorrupt, "A part of the upload is damaged. Begin the upload anew.", which};
}

// All of them, one after another, into a file that is made.
Result<void> JoinChunks(BlobStore& blobs, const std::vector<UploadChunk>& chunks,
                        const std::filesystem::path& to) {
  constexpr std::int64_t kSliceBytes = std::int64_t{8} << 20;
  errno = 0;
  std::ofstream whole(to, std::ios::binary | std::ios::trunc);
  const auto failed = [&] { return FileError("cannot write", to, errno != 0 ? errno : EIO); };
  if (!whole) return failed();
  for (const UploadChunk& chunk : chunks) {
    for (std::int64_t at = 0; at < chunk.bytes; at += kSliceBytes) {
      const std::int64_t wanted = std::min(kSliceBytes, chunk.bytes - at);
      SKYQUILT_TRY_ASSIGN(const std::string bytes, blobs.ReadRange(chunk.key, at, wanted));
      if (static_cast<std::int64_t>(bytes.size()) != wanted) return DamagedPart(chunk.key);
      errno = 0;  // the store may have set it
      whole.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      if (!whole) return failed();
    }
  }
  errno = 0;
  whole.close();
  if (!whole) return failed();
  return {};
}

class ChunkedUploadBytes final : public UploadBytes {
 public:
  using UploadBytes::UploadBytes;

  // What comes is on its way to the next chunk.
  Result<std::unique_ptr<IncomingFile>> Open(const SpooledUpload&) const override {
    auto file = std::make_unique<IncomingFile>(store_.dir());
    if (!file->descriptor.is_open()) return UploadWriteError("open " + file->temporary.string());
    return file;
  }

  Result<void> Sync(IncomingFile& file, SpooledUpload& upload, std::int64_t offset, Time now) const override {
    // What came at once is put where it belongs, and not a second time when it is complete.
    const bool is_whole = upload.offset == 0 && offset == upload.length && !upload.IsPart();
    std::string key, part;
    if (is_whole) {
      SKYQUILT_TRY_ASSIGN(const std::string stored, store_.Adopt(upload.flight_id, file.temporary));
      key = FilesPrefix(upload.flight_id) + stored;
      part = WholeText(stored);
    } else {
      key = NewChunkKey(upload.id, upload.offset);
      SKYQUILT_TRY(store_.blobs().Put(key, file.temporary));
      part = ChunksText({{key, offset - upload.offset}});
    }
    Result<void> saved = SaveChunk(upload, offset, part, now);
    if (!saved && saved.error().code == ErrorCode::kConflict)
      (void)store_.blobs().Remove(key).ok();  // else the sweep
    if (!saved) return saved;
    if (ftruncate(file.descriptor.get(), 0) != 0 || lseek(file.descriptor.get(), 0, SEEK_SET) < 0)
      return Error{ErrorCode::kIo, "The server could not store the upload.", std::strerror(errno)};
    return {};
  }

  Result<std::string> PutInFlight(const SpooledUpload& upload) const override {
    std::string whole = WholeIn(upload.parts);
    if (!whole.empty()) return whole;
    SKYQUILT_TRY_ASSIGN(const std::vector<UploadChunk> chunks, ParseChunks(upload.parts));
    // What came before the store was moved here lies in a file that did not move with it.
    std::int64_t listed = 0;
    for (const UploadChunk& chunk : chunks) listed += chunk.bytes;
    if (listed != upload.offset) return DamagedPart(upload.id);
    const IncomingFile joined(store_.dir());
    SKYQUILT_TRY(JoinChunks(store_.blobs(), chunks, joined.temporary));
    return store_.Adopt(upload.flight_id, joined.temporary);
  }

  // One that came whole may be the file by now that another machine made of it.
  void TakeBack(const SpooledUpload& upload, const std::string& stored_name,
                const Error& why) const override {
    if (WholeIn(upload.parts).empty()) UploadBytes::TakeBack(upload, stored_name, why);
  }

  // Their chunks are its chunks.
  Result<void> Join(const std::vector<SpooledUpload>& parts, SpooledUpload& joined,
                    const std::function<Result<void>()>& enter) const override {
    for (const SpooledUpload& part : parts) joined.parts += part.parts;
    return enter();
  }

  void Remove(const SpooledUpload& upload) const override {
    if (!WholeIn(upload.parts).empty()) return;
    const Result<std::vector<UploadChunk>> chunks = ParseChunks(upload.parts);
    if (!chunks) return;
    for (const UploadChunk& chunk : *chunks) (void)store_.blobs().Remove(chunk.key).ok();  // else the sweep
  }

  Result<int> RemoveExpired(Time now) const override {
    std::vector<SpooledUpload> over;
    {
      const auto db = db_.Lock();
      SKYQUILT_TRY_ASSIGN(
          Statement query,
          db->Query("DELETE FROM upload WHERE expires_us<=?1 RETURNING is_done, parts", ToUs(now)));
      SKYQUILT_TRY(query.Each([&](const Statement& row) {
        // Of one that is done, the chunks went when it was.
        if (row.ColumnInt64(0) == 0) over.emplace_back().parts = row.ColumnText(1);
      }));
    }
    for (const SpooledUpload& upload : over) Remove(upload);
    return static_cast<int>(over.size());
  }

 private:
  // Only who goes on from where the catalogue is: of two machines with the same bytes one is told so.
  Result<void> SaveChunk(SpooledUpload& upload, std::int64_t offset, const std::string& part,
                         Time now) const {
    const auto db = db_.Lock();
    SKYQUILT_TRY(
        db->Change("UPDATE upload SET byte_offset=?3, parts=parts||?4, expires_us=?5"
                   " WHERE id=?1 AND byte_offset=?2 AND parts=?6 AND is_done=0",
                   upload.id, upload.offset, offset, part, ToUs(now + kUploadLifetime), upload.parts));
    if (db->Changes() == 0)
      return Error{ErrorCode::kConflict, "Another request goes on with this upload, or it was removed.", ""};
    upload.offset = offset;
    upload.parts += part;
    upload.expires = now + kUploadLifetime;
    return {};
  }
};

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
    const auto bytes = ParseNumber<std::int64_t>(text.substr(colon + 1, end - colon - 1));
    UploadChunk chunk{std::string(text.substr(0, colon)), bytes.value_or(0)};
    if (chunk.bytes <= 0 || !chunk.key.starts_with(kChunkPrefix)) return DamagedRow();
    chunks.push_back(std::move(chunk));
    text.remove_prefix(end + 1);
  }
  return chunks;
}

std::string WholeText(const std::string& stored_name) { return "=" + stored_name; }

std::string WholeIn(std::string_view text) {
  return text.starts_with('=') && IsId(text.substr(1)) ? std::string(text.substr(1)) : "";
}

Result<int> SweepChunks(CatalogueDb& db, BlobStore& blobs, std::chrono::seconds age) {
  SKYQUILT_TRY_ASSIGN(const auto store_time, TimeOfStore(blobs));
  // Listed before the rows are read, so that what comes meanwhile is not in the list.
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> all, blobs.List(std::string(kChunkPrefix)));
  std::set<std::string> listed;
  {
    const auto access = db.Read();
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> texts,
                        access->AllText("SELECT parts FROM upload WHERE parts<>''"));
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

std::unique_ptr<UploadBytes> BytesInChunks(CatalogueDb& db, const PhotoStore& store) {
  return std::make_unique<ChunkedUploadBytes>(db, store);
}

}  // namespace skyquilt::storage
