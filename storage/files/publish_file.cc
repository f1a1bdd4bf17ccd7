#include "storage/files/publish_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "core/base/process/file_descriptor.h"

namespace skyquilt::storage {

bool IsNoRoom(int number) { return number == ENOSPC || number == EDQUOT || number == EFBIG; }

Error FileError(const std::string& what, const std::filesystem::path& path, int number) {
  const ErrorCode code = IsNoRoom(number) ? ErrorCode::kOutOfSpace : ErrorCode::kIo;
  return {code, what + " " + path.string() + ": " + std::strerror(number), ""};
}

TemporaryFile::~TemporaryFile() {
  std::error_code gone;  // what stays is overwritten by the next run
  std::filesystem::remove(path_, gone);
}

namespace {

Result<void> SyncPath(const std::filesystem::path& path, int flags) {
  const FileDescriptor file(::open(path.c_str(), flags | O_CLOEXEC));
  if (!file.is_open()) return FileError("cannot open", path, errno);
  if (::fsync(file.get()) == 0) return {};
  // Some disks cannot for a folder, as those that a virtual machine shares: its file is there all the same.
  if (errno == EINVAL && (flags & O_DIRECTORY) != 0) return {};
  return FileError("cannot write", path, errno);
}

}  // namespace

Result<void> SyncFolder(const std::filesystem::path& folder) {
  return SyncPath(folder, O_RDONLY | O_DIRECTORY);
}

Result<void> PublishFile(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  if (auto synced = SyncPath(temporary, O_RDONLY); !synced) return synced;
  if (::rename(temporary.c_str(), path.c_str()) != 0) return FileError("cannot publish", path, errno);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  return SyncPath(folder, O_RDONLY | O_DIRECTORY);
}

Result<void> WriteFileAtomically(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  Result<void> done =
      file ? PublishFile(temporary, path) : FileError("cannot write", temporary, errno != 0 ? errno : EIO);
  if (!done) ::unlink(temporary.c_str());
  return done;
}

Result<std::string> ReadWholeFile(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open() && errno == ENOENT)
    return Error{ErrorCode::kNotFound, "There is no file " + path.string(), ""};
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (file.bad() || !file.is_open()) return FileError("cannot read", path, errno != 0 ? errno : EIO);
  return bytes;
}

Result<std::string> ReadRangeOfFile(const std::filesystem::path& path, std::int64_t offset,
                                    std::int64_t length) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file.is_open() && errno == ENOENT)
    return Error{ErrorCode::kNotFound, path.string() + " is not there.", path.string()};
  if (!file.is_open()) return FileError("cannot open", path, errno);
  std::string bytes(static_cast<std::size_t>(length), '\0');
  const ssize_t have = file.ReadAt(static_cast<std::uint64_t>(offset), bytes.data(), bytes.size());
  if (have < 0) return FileError("cannot read", path, errno);
  bytes.resize(static_cast<std::size_t>(have));
  return bytes;
}

Result<std::unique_ptr<StreamFile>> StreamFile::Create(const std::filesystem::path& path) {
  std::filesystem::path temporary = path;
  temporary += ".tmp";
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (file == nullptr) return FileError("cannot write", temporary, errno);
  return std::unique_ptr<StreamFile>(new StreamFile(path, std::move(temporary), file));
}

StreamFile::~StreamFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  std::error_code gone;  // nothing to do about a temporary file that will not go; the next run overwrites it
  std::filesystem::remove(temporary_, gone);
}

void StreamFile::Keep(bool went_well) {
  if (!went_well && failure_ == 0) failure_ = errno != 0 ? errno : EIO;
}

void StreamFile::Write(std::string_view bytes) {
  if (failure_ == 0) Keep(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
  position_ += bytes.size();
}

void StreamFile::WriteAt(std::uint64_t offset, std::string_view bytes) {
  if (failure_ != 0) return;
  Keep(fseeko(file_, static_cast<off_t>(offset), SEEK_SET) == 0);
  if (failure_ == 0) Keep(std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size());
  if (failure_ == 0) Keep(fseeko(file_, static_cast<off_t>(position_), SEEK_SET) == 0);
}

Result<void> StreamFile::Publish() {
  if (failure_ == 0) Keep(std::fflush(file_) == 0);
  if (failure_ != 0) return FileError("cannot write", temporary_, failure_);
  if (auto published = PublishFile(temporary_, path_); !published) return published;
  std::fclose(file_);
  file_ = nullptr;
  return {};
}

}  // namespace skyquilt::storage
