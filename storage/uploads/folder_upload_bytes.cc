// BytesInFolder: an upload is the file uploads/<id>, to which its bytes are appended.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "core/base/try.h"
#include "storage/uploads/upload_spool.h"

namespace skyquilt::storage {
namespace {

Error JoinError(const std::filesystem::path& path) {
  Error error = UploadWriteError(path.string());
  error.message = error.code == ErrorCode::kOutOfSpace
                      ? "The server's disk is full. Free some space and ask again for the whole upload."
                      : "The server could not put the parts of the upload together.";
  return error;
}

class FolderUploadBytes final : public UploadBytes {
 public:
  using UploadBytes::UploadBytes;

  Result<void> Create(const std::string& id) const override {
    const FileDescriptor file(
        open(PathOf(id).c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640));
    if (!file.is_open()) return UploadWriteError("open " + PathOf(id).string());
    return {};
  }

  Result<std::unique_ptr<IncomingFile>> Open(const SpooledUpload& upload) const override {
    const std::filesystem::path path = PathOf(upload.id);
    FileDescriptor file(open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
    if (!file.is_open()) return UploadWriteError("open " + path.string());
    struct stat status {};
    if (fstat(file.get(), &status) != 0) return UploadWriteError("stat " + path.string());
    // As after a backup whose catalogue is younger: zeros would stand for what is not there.
    if (status.st_size < upload.offset)
      return Error{ErrorCode::kCorrupt,
                   "Bytes of this upload are missing on the server. Begin the upload anew.", path.string()};
    // Behind the offset there may be bytes that never were promised.
    if (ftruncate(file.get(), upload.offset) != 0 || lseek(file.get(), upload.offset, SEEK_SET) < 0)
      return UploadWriteError("truncate " + path.string());
    return std::make_unique<IncomingFile>(std::move(file));
  }

  Result<void> Sync(IncomingFile& file, SpooledUpload& upload, std::int64_t offset, Time now) const override {
    if (fdatasync(file.descriptor.get()) != 0) return UploadWriteError("sync " + PathOf(upload.id).string());
    const auto db = db_.Lock();
    SKYQUILT_TRY(db->Change("UPDATE upload SET byte_offset=?2, expires_us=?3 WHERE id=?1", upload.id, offset,
                            ToUs(now + kUploadLifetime)));
    if (db->Changes() == 0) return NoSuchUpload();
    upload.offset = offset;
    upload.expires = now + kUploadLifetime;
    return {};
  }

  // A second name for the bytes: a crash leaves either the complete upload or the file, and garbage that the
  // sweep removes.
  Result<std::string> PutInFlight(const SpooledUpload& upload) const override {
    SKYQUILT_TRY(Open(upload));  // it has its bytes, and no more
    return store_.Adopt(upload.flight_id, PathOf(upload.id));
  }

  Result<void> Join(const std::vector<SpooledUpload>& parts, SpooledUpload& joined,
                    const std::function<Result<void>()>& enter) const override {
    Result<void> done = CopyParts(parts, PathOf(joined.id));
    if (done) done = enter();
    if (!done) {
      Remove(joined);
      return done;
    }
    for (const SpooledUpload& part : parts) Remove(part);
    return {};
  }

  void Remove(const SpooledUpload& upload) const override { unlink(PathOf(upload.id).c_str()); }

  Result<int> RemoveExpired(Time now) const override {
    // Held to the end: who goes on with one does so before, and it is not over, or hears that it is gone.
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> over,
                        db->AllText("SELECT id FROM upload WHERE expires_us<=?1", ToUs(now)));
    // The bytes first: as long as the row is there, they are known to be nobody's.
    int count = 0;
    for (const std::string& id : over) {
      if (unlink(PathOf(id).c_str()) == 0) ++count;
    }
    SKYQUILT_TRY(db->Change("DELETE FROM upload WHERE expires_us<=?", ToUs(now)));
    return count;
  }

 private:
  std::filesystem::path PathOf(const std::string& id) const { return store_.dir().Uploads() / id; }

  Result<void> CopyParts(const std::vector<SpooledUpload>& parts, const std::filesystem::path& to) const {
    const FileDescriptor whole(open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640));
    if (!whole.is_open()) return JoinError(to);
    for (const SpooledUpload& part : parts) {
      const FileDescriptor from(open(PathOf(part.id).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
      if (!from.is_open()) return JoinError(PathOf(part.id));
      // Behind the offset there may be bytes that never were promised.
      for (std::int64_t left = part.offset; left > 0;) {
        const ssize_t copied =
            copy_file_range(from.get(), nullptr, whole.get(), nullptr, static_cast<std::size_t>(left), 0);
        if (copied < 0 && errno == EINTR) continue;
        if (copied < 0) return JoinError(to);
        if (copied == 0)
          return Error{ErrorCode::kIo, "A part of the upload is damaged on the server.", PathOf(part.id)};
        left -= copied;
      }
    }
    if (fdatasync(whole.get()) != 0) return JoinError(to);
    return {};
  }
};

}  // namespace

std::unique_ptr<UploadBytes> BytesInFolder(CatalogueDb& db, const PhotoStore& store) {
  return std::make_unique<FolderUploadBytes>(db, store);
}

}  // namespace skyquilt::storage
