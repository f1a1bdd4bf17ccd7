#include "storage/uploads/zip_directory.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::storage {
namespace {

// APPNOTE.TXT 6.3, sections 4.3.12 to 4.3.16.
constexpr std::string_view kEntry("PK\1\2", 4);
constexpr std::string_view kEnd("PK\5\6", 4);
constexpr std::string_view kEnd64("PK\6\6", 4);
constexpr std::string_view kLocator64("PK\6\7", 4);
constexpr std::size_t kEndBytes = 22, kEnd64Bytes = 56, kLocator64Bytes = 20;
constexpr std::uint64_t kTail = kEndBytes + 65'535;  // the end may have a comment
constexpr std::size_t kBlock = std::size_t{1} << 18;

std::uint64_t Little(std::string_view bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = size; i > 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[at + i - 1]);
  return value;
}

std::string ReadAt(std::ifstream& file, std::uint64_t at, std::size_t size) {
  std::string bytes(size, '\0');
  file.clear();
  file.seekg(static_cast<std::streamoff>(at));
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return bytes;
}

// The first place at which a reader might take the directory to begin: what the end says, and what its length
// says.
std::optional<std::uint64_t> Begin(std::ifstream& file, std::uint64_t file_bytes) {
  const std::uint64_t tail_at = file_bytes - std::min(file_bytes, kTail);
  const std::string tail = ReadAt(file, tail_at, static_cast<std::size_t>(file_bytes - tail_at));
  const std::size_t end = tail.rfind(kEnd);
  if (end == std::string::npos || tail.size() - end < kEndBytes) return std::nullopt;
  const std::uint64_t size = Little(tail, end + 12, 4);
  std::uint64_t begin = std::min(Little(tail, end + 16, 4), tail_at + end - std::min(tail_at + end, size));
  if (end >= kLocator64Bytes && tail.compare(end - kLocator64Bytes, 4, kLocator64) == 0) {
    const std::uint64_t end64_at = Little(tail, end - kLocator64Bytes + 8, 8);
    if (end64_at < file_bytes) {
      const std::string end64 = ReadAt(file, end64_at, kEnd64Bytes);
      if (end64.size() == kEnd64Bytes && end64.starts_with(kEnd64))
        begin = std::min(begin, Little(end64, 48, 8));
    }
  }
  return begin;
}

}  // namespace

int CountZipEntries(const std::filesystem::path& path, int most) {
  std::error_code missing;  // whoever opens it says so
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, missing);
  std::ifstream file(path, std::ios::binary);
  if (missing || !file) return 0;
  const std::optional<std::uint64_t> begin = Begin(file, file_bytes);
  if (!begin) return 0;
  int count = 0;
  std::string kept;  // of the block before: a signature may lie across two
  for (std::uint64_t at = *begin; at < file_bytes && count <= most;) {
    const std::string block = ReadAt(file, at, kBlock);
    if (block.empty()) break;
    at += block.size();
    kept += block;
    for (std::size_t found = kept.find(kEntry); found != std::string::npos && count <= most;
         found = kept.find(kEntry, found + kEntry.size()))
      ++count;
    kept.erase(0, kept.size() - std::min(kept.size(), kEntry.size() - 1));
  }
  return count;
}

}  // namespace skyquilt::storage
