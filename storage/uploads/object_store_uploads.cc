// UploadSpool where photos lie elsewhere than in the data folder: chunks instead of a file.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "core/base/try.h"
#include "storage/uploads/upload_chunks.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::storage {
namespace {

// Gone with the scope.
class JoinedFile {
 public:
  explicit JoinedFile(const DataDir& dir) : path_(dir.Incoming() / dir.NewTemporaryName(kUploadKind)) {}
  ~JoinedFile() { unlink(path_.c_str()); }
  JoinedFile(const JoinedFile&) = delete;
  JoinedFile& operator=(const JoinedFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

// Only who goes on from where the catalogue is: of two machines with the same bytes one is told so.
Result<void> UploadSpool::SaveChunk(SpooledUpload& upload, std::int64_t offset, const std::string& part,
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

Result<void> UploadSpool::Append::SyncToObjectStore(Time now) {
  BlobStore& blobs = spool_.store_.blobs();
  // What came at once is put where it belongs, and not a second time when it is complete.
  const bool is_whole = upload_.offset == 0 && written_ == upload_.length && !upload_.IsPart();
  std::string key, part;
  if (is_whole) {
    SKYQUILT_TRY_ASSIGN(const std::string stored, spool_.store_.Adopt(upload_.flight_id, temporary_));
    key = FilesPrefix(upload_.flight_id) + stored;
    part = WholeText(stored);
  } else {
    key = NewChunkKey(upload_.id, upload_.offset);
    SKYQUILT_TRY(blobs.Put(key, temporary_));
    part = ChunksText({{key, written_ - upload_.offset}});
  }
  Result<void> saved = spool_.SaveChunk(upload_, written_, part, now);
  if (!saved && saved.error().code == ErrorCode::kConflict) (void)blobs.Remove(key).ok();  // else the sweep
  if (!saved) return saved;
  if (ftruncate(fd_, 0) != 0 || lseek(fd_, 0, SEEK_SET) < 0)
    return Error{ErrorCode::kIo, "The server could not store the upload.", std::strerror(errno)};
  return {};
}

Result<void> UploadSpool::MakeFileInObjectStore(SpooledUpload& upload) const {
  const std::string whole = WholeIn(upload.parts);
  std::string stored = whole;
  if (whole.empty()) {
    SKYQUILT_TRY_ASSIGN(const std::vector<UploadChunk> chunks, ParseChunks(upload.parts));
    const JoinedFile joined(store_.dir());
    SKYQUILT_TRY(JoinChunks(store_.blobs(), chunks, joined.path()));
    SKYQUILT_TRY_ASSIGN(stored, store_.Adopt(upload.flight_id, joined.path()));
  }
  const Result<StoredFile> added = catalogue_.AddFileUnderFreeName(
      upload.flight_id, {upload.name, stored, upload.offset}, Now(), upload.id);
  if (!added) {
    // One that came whole may be the file by now that another machine made of it.
    if (whole.empty()) store_.Remove(upload.flight_id, stored);
    return added.error();
  }
  if (whole.empty()) RemoveChunks(upload.parts);
  upload.is_done = true;
  upload.file = *added;
  return {};
}

void UploadSpool::RemoveChunks(const std::string& parts) const {
  if (parts.empty() || !WholeIn(parts).empty()) return;
  const Result<std::vector<UploadChunk>> chunks = ParseChunks(parts);
  if (!chunks) return;
  for (const UploadChunk& chunk : *chunks) (void)store_.blobs().Remove(chunk.key).ok();  // else the sweep
}

Result<int> UploadSpool::RemoveExpiredInObjectStore(Time now) const {
  std::vector<std::string> over;
  {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(
        Statement query,
        db->Query("DELETE FROM upload WHERE expires_us<=?1 RETURNING is_done, parts", ToUs(now)));
    SKYQUILT_TRY(query.Each([&](const Statement& row) {
      // Of one that is done, the chunks went when it was.
      if (row.ColumnInt64(0) == 0) over.emplace_back(row.ColumnText(1));
    }));
  }
  for (const std::string& parts : over) RemoveChunks(parts);
  return static_cast<int>(over.size());
}

}  // namespace skyquilt::storage
