#include "core/flight/bytes/byte_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

class FileBytes final : public ByteSource {
 public:
  FileBytes(FileDescriptor file, std::uint64_t size) : file_(std::move(file)), size_(size) {}
  std::uint64_t size() const override { return size_; }

  bool Read(std::uint64_t offset, std::span<std::uint8_t> into) override {
    if (offset > size_ || into.size() > size_ - offset) return false;
    return file_.ReadAt(offset, into.data(), into.size()) == static_cast<ssize_t>(into.size());
  }

 private:
  FileDescriptor file_;
  std::uint64_t size_;
};

}  // namespace

std::vector<std::uint8_t> ByteSource::ReadUpTo(std::uint64_t offset, std::size_t count) {
  if (offset >= size()) return {};
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(count, size() - offset)));
  if (!Read(offset, bytes)) bytes.clear();
  return bytes;
}

bool MemoryBytes::Read(std::uint64_t offset, std::span<std::uint8_t> into) {
  if (offset > bytes_.size() || into.size() > bytes_.size() - offset) return false;
  if (!into.empty()) std::memcpy(into.data(), bytes_.data() + offset, into.size());
  return true;
}

Result<std::unique_ptr<ByteSource>> OpenFileBytes(const std::filesystem::path& path) {
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file.is_open()) {
    const int reason = errno;
    return Because(reason == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
                   {RemarkCode::kFileUnread,
                    {{"file", path.filename().string()}, {"system_words", std::strerror(reason)}}},
                   path.string());
  }
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return Because(ErrorCode::kUnsupportedFormat,
                   {RemarkCode::kFileIrregular, {{"file", path.filename().string()}}}, path.string());
  }
  const auto size = static_cast<std::uint64_t>(status.st_size);
  return std::unique_ptr<ByteSource>(new FileBytes(std::move(file), size));
}

Result<MappedFile> MappedFile::Open(const std::filesystem::path& path) {
  const auto failed = [&](std::string_view act) {
    return Because(ErrorCode::kIo,
                   {RemarkCode::kFileUnread,
                    {{"file", path.filename().string()}, {"system_words", std::strerror(errno)}}},
                   fmt::format("{}: {}", act, path.string()));
  };
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open()) return failed("open");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return Because(ErrorCode::kIo, {RemarkCode::kFileIrregular, {{"file", path.filename().string()}}},
                   path.string());
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return MappedFile(nullptr, 0);
  void* mapped = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (mapped == MAP_FAILED) return failed("map");
  ::madvise(mapped, size, MADV_SEQUENTIAL);
  return MappedFile(static_cast<const std::uint8_t*>(mapped), size);
}

void MappedFile::Unmap::operator()(const std::uint8_t* data) const {
  ::munmap(const_cast<std::uint8_t*>(data), size);
}

void MappedFile::ReleaseBefore(std::size_t offset) const {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const std::size_t whole = std::min(offset, bytes().size()) / page * page;
  if (whole > 0) ::madvise(const_cast<std::uint8_t*>(data_.get()), whole, MADV_DONTNEED);
}

}  // namespace skyquilt::flight
