#include "core/flight/bytes/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/flight/remarks/because.h"

namespace skyquilt::flight {

Result<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  const auto failed = [&](std::string_view act) {
    return Because(ErrorCode::kIo,
                   {RemarkCode::kFileUnread,
                    {{"file", path.filename().string()}, {"system_words", std::strerror(errno)}}},
                   fmt::format("{}: {}", act, path.string()));
  };
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return failed("open");
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    return Because(ErrorCode::kIo, {RemarkCode::kFileIrregular, {{"file", path.filename().string()}}},
                   path.string());
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) {
    ::close(descriptor);
    return MappedFile(nullptr, 0);
  }
  void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  const int error_number = errno;
  ::close(descriptor);
  if (mapped == MAP_FAILED) {
    errno = error_number;
    return failed("map");
  }
  ::madvise(mapped, size, MADV_SEQUENTIAL);
  return MappedFile(static_cast<const std::uint8_t*>(mapped), size);
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::uint8_t*>(data_), size_);
}

void MappedFile::ReleaseBefore(std::size_t offset) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t whole = std::min(offset, size_) / page * page;
  if (whole > 0) ::madvise(const_cast<std::uint8_t*>(data_), whole, MADV_DONTNEED);
}

}  // namespace skyquilt::flight
