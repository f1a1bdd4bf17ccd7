#include "storage/db/space_reserve.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdint>

#include "core/base/process/file_descriptor.h"

namespace skyquilt::storage {
namespace {

constexpr std::int64_t kSpaceReserveBytes = std::int64_t{8} << 20;
// What a start writes before it can serve: the write-ahead log and the memory it shares.
constexpr std::int64_t kStartBytes = std::int64_t{1} << 20;

std::int64_t FreeBytesAt(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) return 0;
  return static_cast<std::int64_t>(disk.f_bavail) * static_cast<std::int64_t>(disk.f_frsize);
}

}  // namespace

void SpaceReserve::Fill() const {
  struct stat status {};
  if (stat(path_.c_str(), &status) == 0 && status.st_size >= kSpaceReserveBytes) return;
  if (FreeBytesAt(path_.parent_path()) < 2 * kSpaceReserveBytes) return;
  const FileDescriptor file(open(path_.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.is_open()) return;
  // A partial reserve is recognised by its size, which the allocation sets.
  if (posix_fallocate(file.get(), 0, kSpaceReserveBytes) != 0) unlink(path_.c_str());
}

bool SpaceReserve::Release() const { return unlink(path_.c_str()) == 0; }

bool SpaceReserve::IsNeeded() const { return FreeBytesAt(path_.parent_path()) < kStartBytes; }

}  // namespace skyquilt::storage
