#include "storage/uploads/photo_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>

#include "core/base/check.h"
#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/blobs/folder_blobs.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

// Kept free so that the catalogue can still be written when uploads have filled the disk.
constexpr std::uint64_t kReservedBytes = std::uint64_t{32} << 20;

Error NotStored(ErrorCode code, std::string detail) {
  return {code,
          code == ErrorCode::kOutOfSpace ? "The server's disk is full. Free some space and try again."
                                         : "The server could not store the file.",
          std::move(detail)};
}

Error OsError(const std::string& what, int code) {
  return NotStored(IsNoRoom(code) ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
                   what + ": " + std::strerror(code));
}

Result<void> SyncStored(const std::filesystem::path& folder) {
  const Result<void> synced = SyncFolder(folder);
  if (!synced) return NotStored(synced.error().code, synced.error().message);
  return {};
}

Error FolderGone() { return flight::Because(ErrorCode::kUnavailable, flight::RemarkCode::kFailFolderGone); }

Error TooLarge() {
  return flight::Because(ErrorCode::kTooLarge,
                         {flight::RemarkCode::kFailFileTooLarge, {{"most_gib", kMaxFileBytes >> 30}}});
}

// The flight's folders, but never those above: a data folder that went away meanwhile must not be made anew.
Result<void> MakeFilesFolder(const DataDir& dir, const std::string& flight_id) {
  for (const auto& folder : {dir.Flight(flight_id), dir.Files(flight_id)}) {
    if (mkdir(folder.c_str(), 0755) == 0 || errno == EEXIST) continue;
    const int code = errno;
    if (code == ENOENT && access(dir.Flights().c_str(), F_OK) != 0) return FolderGone();
    return OsError("make " + folder.string(), code);
  }
  return {};
}

}  // namespace

bool IsValidUtf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const int follow = lead < 0x80         ? 0
                       : (lead >> 5) == 6  ? 1
                       : (lead >> 4) == 14 ? 2
                       : (lead >> 3) == 30 ? 3
                                           : -1;
    if (follow < 0 || i + static_cast<std::size_t>(follow) >= text.size()) return false;
    std::uint32_t point = follow == 0 ? lead : lead & (0x3fu >> follow);
    for (int k = 1; k <= follow; ++k) {
      const auto next = static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]);
      if ((next >> 6) != 2) return false;
      point = (point << 6) | (next & 0x3fu);
    }
    constexpr std::uint32_t kSmallest[] = {0, 0x80, 0x800, 0x10000};  // a longer form than needed is refused
    if (point < kSmallest[follow] || point > 0x10ffff || (point >= 0xd800 && point <= 0xdfff)) return false;
    i += static_cast<std::size_t>(follow) + 1;
  }
  return true;
}

Result<void> CheckFileName(std::string_view name) {
  const auto refuse = [](const char* why) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("This file name cannot be used: {}.", why), ""};
  };
  if (name.empty()) return refuse("it is empty");
  if (name.size() > 255) return refuse("it is longer than 255 bytes");
  if (!IsValidUtf8(name)) return refuse("it is not UTF-8");
  if (name == "." || name == "..") return refuse("it means a folder");
  for (const char c : name) {
    if (c == '/' || c == '\\') return refuse("it has a slash in it; send the name alone, without folders");
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return refuse("it has a control character in it");
  }
  return {};
}

IncomingFile::IncomingFile(const DataDir& dir)
    : temporary(dir.Incoming() / dir.NewTemporaryName(kUploadKind)),
      descriptor(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0640)) {}

IncomingFile::~IncomingFile() {
  if (!temporary.empty()) unlink(temporary.c_str());  // what stays the sweep removes
}

bool IncomingFile::Write(std::span<const std::uint8_t> bytes, std::int64_t& written) const {
  const std::size_t wrote = descriptor.Write(bytes.data(), bytes.size());
  written += static_cast<std::int64_t>(wrote);
  return wrote == bytes.size();
}

Upload::Upload(std::unique_ptr<IncomingFile> file, std::filesystem::path folder,
               std::shared_ptr<BlobStore> elsewhere, std::string prefix)
    : file_(std::move(file)),
      folder_(std::move(folder)),
      stored_name_(NewId()),
      elsewhere_(std::move(elsewhere)),
      prefix_(std::move(prefix)) {}

Result<void> Upload::Write(std::span<const std::uint8_t> bytes) {
  if (bytes_ + static_cast<std::int64_t>(bytes.size()) > kMaxFileBytes) return TooLarge();
  if (!file_->Write(bytes, bytes_)) return OsError("write " + file_->temporary.string(), errno);
  return {};
}

Result<std::string> Upload::Finish() {
  if (bytes_ == 0) return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailFileEmpty);
  if (elsewhere_ != nullptr) {
    file_->descriptor.Close();
    SKYQUILT_TRY(elsewhere_->Put(prefix_ + stored_name_, file_->temporary));
    unlink(std::exchange(file_->temporary, {}).c_str());  // what stays the sweep removes
    return stored_name_;
  }
  if (fsync(file_->descriptor.get()) != 0) return OsError("fsync " + file_->temporary.string(), errno);
  file_->descriptor.Close();
  const std::filesystem::path published = folder_ / stored_name_;
  // The flight may have been deleted meanwhile; then its folder is gone and this fails, as it should.
  if (rename(file_->temporary.c_str(), published.c_str()) != 0) {
    const int code = errno;
    if (access(folder_.parent_path().parent_path().c_str(), F_OK) != 0) return FolderGone();
    if (code == ENOENT) return Error{ErrorCode::kNotFound, "The flight was deleted during the upload.", ""};
    errno = code;
    return OsError("rename to " + published.string(), errno);
  }
  file_->temporary.clear();
  SKYQUILT_TRY(SyncStored(folder_));
  return stored_name_;
}

PhotoStore::PhotoStore(DataDir dir, std::shared_ptr<BlobStore> blobs)
    : dir_(std::move(dir)),
      blobs_(blobs != nullptr ? std::move(blobs) : std::make_shared<FolderBlobs>(dir_.root())) {}

Result<void> PhotoStore::CheckSpace(std::int64_t declared_bytes) const {
  if (declared_bytes > kMaxFileBytes) return TooLarge();
  struct statvfs disk {};
  if (statvfs(dir_.root().c_str(), &disk) != 0)
    return errno == ENOENT ? FolderGone() : OsError("statvfs", errno);
  const std::uint64_t free_bytes = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  if (free_bytes < kReservedBytes + static_cast<std::uint64_t>(declared_bytes)) {
    return flight::Because(ErrorCode::kOutOfSpace, flight::RemarkCode::kFailNoRoom);
  }
  return {};
}

Result<std::string> PhotoStore::Adopt(const std::string& flight_id, const std::filesystem::path& path) const {
  const std::string stored_name = NewId();
  if (!blobs_->IsFolder()) {
    SKYQUILT_TRY(blobs_->Put(FilesPrefix(flight_id) + stored_name, path));
    return stored_name;
  }
  SKYQUILT_TRY(MakeFilesFolder(dir_, flight_id));
  const std::filesystem::path stored = dir_.Files(flight_id) / stored_name;
  if (link(path.c_str(), stored.c_str()) != 0) return OsError("link " + stored.string(), errno);
  SKYQUILT_TRY(SyncStored(dir_.Files(flight_id)));
  return stored_name;
}

Result<Upload> PhotoStore::Begin(const std::string& flight_id, std::int64_t declared_bytes) const {
  SKYQUILT_TRY(CheckSpace(declared_bytes));
  const bool is_here = blobs_->IsFolder();
  if (is_here) SKYQUILT_TRY(MakeFilesFolder(dir_, flight_id));
  auto file = std::make_unique<IncomingFile>(dir_);
  if (!file->descriptor.is_open()) return OsError("open " + file->temporary.string(), errno);
  return Upload(std::move(file), dir_.Files(flight_id), is_here ? nullptr : blobs_, FilesPrefix(flight_id));
}

std::filesystem::path PhotoStore::PathOf(const std::string& flight_id, const std::string& stored_name) const {
  SKYQUILT_CHECK(IsId(stored_name), "an unchecked name came near a path");
  return blobs_->FolderOf(FilesPrefix(flight_id)) / stored_name;
}

Result<LocalBlob> PhotoStore::Fetch(const std::string& flight_id, const std::string& stored_name) const {
  // In the data folder it is opened by whoever wants it, and says then whether it is there.
  if (blobs_->IsFolder()) return LocalBlob{PathOf(flight_id, stored_name), nullptr};
  SKYQUILT_CHECK(IsId(stored_name), "an unchecked name came near a key");
  return blobs_->Local(FilesPrefix(flight_id) + stored_name);
}

Result<std::vector<LocalBlob>> PhotoStore::FetchAll(const std::string& flight_id,
                                                    const std::vector<StoredFile>& files) const {
  constexpr int kFetchedSideBySide = 8;
  std::vector<LocalBlob> fetched(files.size());
  std::vector<std::optional<Error>> failures(files.size());
  std::atomic<bool> has_failed = false;
  ParallelFor(files.size(), blobs_->IsFolder() ? 1 : kFetchedSideBySide, [&](std::size_t i) {
    if (has_failed) return;
    Result<LocalBlob> one = Fetch(flight_id, files[i].stored_name);
    if (one) {
      fetched[i] = *std::move(one);
    } else {
      failures[i] = one.error();
      has_failed = true;
    }
  });
  for (const std::optional<Error>& failure : failures) {
    if (failure) return *failure;
  }
  return fetched;
}

void PhotoStore::Remove(const std::string& flight_id, const std::string& stored_name) const {
  SKYQUILT_CHECK(IsId(stored_name), "an unchecked name came near a path");
  // A file that stays (a failing disk, a store that is away) a later sweep moves to lost/.
  (void)blobs_->Remove(FilesPrefix(flight_id) + stored_name).ok();
}

void PhotoStore::TakeBack(const std::string& flight_id, const std::string& stored_name,
                          const Error& why) const {
  if (why.code != ErrorCode::kUnavailable) Remove(flight_id, stored_name);
}

void PhotoStore::RemoveFlight(const std::string& flight_id, const std::vector<std::string>& jobs) const {
  // Out of sight in one step, then gone piece by piece; what a crash leaves in work/ the sweep removes: its
  // name says that it was deleted.
  const std::filesystem::path trash = dir_.Work() / dir_.NewTemporaryName(kDeletedKind);
  std::error_code ignored;
  std::filesystem::rename(dir_.Flight(flight_id), trash, ignored);
  std::filesystem::remove_all(trash, ignored);
  for (const auto& entry : std::filesystem::directory_iterator(dir_.Work(), ignored)) {
    const std::string name = entry.path().filename().string();
    const auto is_its = [&](const std::string& job) { return name.starts_with(job + "-"); };
    if (std::any_of(jobs.begin(), jobs.end(), is_its)) std::filesystem::remove_all(entry.path(), ignored);
  }
  if (!blobs_->IsFolder()) (void)RemoveFlightBlobs(*blobs_, flight_id).ok();  // as the header says
}

}  // namespace skyquilt::storage
