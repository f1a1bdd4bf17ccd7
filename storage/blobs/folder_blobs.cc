#include "storage/blobs/folder_blobs.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

Error NoBlob(const fs::path& path) {
  return {ErrorCode::kNotFound, path.string() + " is not there.", path.string()};
}

BlobInfo InfoOf(std::string key, const struct stat& status) {
  const auto changed = std::chrono::seconds(status.st_mtim.tv_sec);
  return {std::move(key), status.st_size, std::chrono::system_clock::time_point(changed)};
}

// What PublishFile renames: never seen by List, and gone where that comes to nothing.
TemporaryFile Temporary(const fs::path& path) { return {path.parent_path() / (".put-" + NewId()), ""}; }

bool IsTemporary(const fs::path& path) { return path.filename().string().starts_with(".put-"); }

Result<void> MakeParent(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) return FileError("cannot make", path.parent_path(), error.value());
  return {};
}

}  // namespace

fs::path FolderBlobs::PathOf(const std::string& key) const {
  RequireKey(key);
  return root_ / key;
}

Result<void> FolderBlobs::Put(const std::string& key, const fs::path& file) {
  const fs::path path = PathOf(key);
  const TemporaryFile temporary = Temporary(path);
  SKYQUILT_TRY(MakeParent(path));
  std::error_code error;
  fs::copy_file(file, temporary.path(), error);
  if (error) return FileError("cannot write", temporary.path(), error.value());
  return PublishFile(temporary.path(), path);
}

Result<void> FolderBlobs::PutIfAbsent(const std::string& key, std::string_view bytes) {
  const fs::path path = PathOf(key);
  const TemporaryFile temporary = Temporary(path);
  SKYQUILT_TRY(MakeParent(path));
  SKYQUILT_TRY(WriteFileAtomically(temporary.path(), bytes));
  const bool is_linked = link(temporary.c_str(), path.c_str()) == 0;
  if (!is_linked && errno == EEXIST)
    return Error{ErrorCode::kConflict, path.string() + " is there already.", ""};
  if (!is_linked) return FileError("cannot write", path, errno);
  return SyncFolder(path.parent_path());
}

Result<std::string> FolderBlobs::ReadRange(const std::string& key, std::int64_t offset, std::int64_t length) {
  return ReadRangeOfFile(PathOf(key), offset, length);
}

Result<BlobInfo> FolderBlobs::Find(const std::string& key) {
  struct stat status {};
  const fs::path path = PathOf(key);
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return NoBlob(path);
  return InfoOf(key, status);
}

Result<std::vector<BlobInfo>> FolderBlobs::List(const std::string& prefix) {
  std::vector<BlobInfo> found;
  const fs::path folder = root_ / prefix.substr(0, prefix.rfind('/') + 1);
  std::error_code missing;  // a folder that is not there has none
  for (auto entry = fs::recursive_directory_iterator(folder, missing);
       !missing && entry != fs::recursive_directory_iterator(); entry.increment(missing)) {
    struct stat status {};
    std::string key = entry->path().lexically_relative(root_).string();
    if (!key.starts_with(prefix) || IsTemporary(entry->path())) continue;
    if (lstat(entry->path().c_str(), &status) == 0 && S_ISREG(status.st_mode))
      found.push_back(InfoOf(std::move(key), status));
  }
  // Half a list would have what lies behind a disk's error taken for gone.
  if (missing && missing != std::errc::no_such_file_or_directory)
    return FileError("cannot list", folder, missing.value());
  std::sort(found.begin(), found.end(), [](const BlobInfo& a, const BlobInfo& b) { return a.key < b.key; });
  return found;
}

Result<void> FolderBlobs::Remove(const std::string& key) {
  const fs::path path = PathOf(key);
  if (unlink(path.c_str()) != 0 && errno != ENOENT) return FileError("cannot remove", path, errno);
  return {};
}

Result<int> FolderBlobs::RemoveBelow(const std::string& prefix) {
  SKYQUILT_CHECK(prefix.ends_with('/') && prefix.size() > 1, "what is removed as a whole is a folder");
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> blobs, List(prefix));
  std::error_code error;
  fs::remove_all(PathOf(prefix.substr(0, prefix.size() - 1)), error);
  if (error) return FileError("cannot remove", root_ / prefix, error.value());
  return static_cast<int>(blobs.size());
}

Result<LocalBlob> FolderBlobs::Local(const std::string& key) {
  SKYQUILT_TRY(Find(key));
  return LocalBlob{PathOf(key), nullptr};
}

}  // namespace skyquilt::storage
