#include "storage/data_dir.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "core/base/check.h"
#include "storage/ids.h"

namespace skyquilt::storage {

std::string RevisionFolderName(std::int64_t revision) { return fmt::format("r{}", revision); }

Result<DataDir> DataDir::Open(const std::filesystem::path& root) {
  std::error_code error;
  DataDir dir(std::filesystem::absolute(root).lexically_normal());
  for (const auto& folder : {dir.root(), dir.Flights(), dir.Uploads(), dir.Incoming(), dir.Work()}) {
    std::filesystem::create_directories(folder, error);
    if (error) {
      const bool is_full = error == std::errc::no_space_on_device;
      return Error{is_full ? ErrorCode::kOutOfSpace : ErrorCode::kIo,
                   fmt::format("The folder {} cannot be made: {}.", folder.string(), error.message()), ""};
    }
  }
  return dir;
}

std::filesystem::path DataDir::Flight(const std::string& flight_id) const {
  SKYQUILT_CHECK(IsId(flight_id), "an unchecked id came near a path");
  return Flights() / flight_id;
}

std::filesystem::path DataDir::Files(const std::string& flight_id) const {
  return Flight(flight_id) / "files";
}

std::filesystem::path DataDir::Revision(const std::string& flight_id, std::int64_t revision) const {
  return Flight(flight_id) / RevisionFolderName(revision);
}

Result<DataDirLock> DataDirLock::Take(const DataDir& dir) {
  const std::string path = (dir.root() / "server.lock").string();
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return Error{ErrorCode::kIo, "The file " + path + " cannot be written.", ""};
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    close(fd);
    return Error{
        ErrorCode::kConflict,
        "Another server uses " + dir.root().string() + " already. Stop it, or use another --data folder.",
        ""};
  }
  return DataDirLock(fd);
}

DataDirLock::~DataDirLock() {
  if (fd_ >= 0) close(fd_);
}

DataDirLock::DataDirLock(DataDirLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

}  // namespace skyquilt::storage
