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
constexpr std::string_view kFile("PK\3\4", 4);
constexpr std::string_view kEntry("PK\1\2", 4);
constexpr std::string_view kEnd("PK\5\6", 4);
constexpr std::string_view kEnd64("PK\6\6", 4);
constexpr std::string_view kLocator64("PK\6\7", 4);
constexpr std::size_t kFileBytes = 30, kEntryBytes = 46;
constexpr std::uint64_t kIn64 = 0xFFFFFFFF;  // in the place of a number that is elsewhere, in 64 bits
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

// Calls `take` with the place of each signature of an entry, in order, until it says false.
template <typename Take>
void ForEachEntry(const std::filesystem::path& path, Take take) {
  std::error_code missing;  // whoever opens it says so
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, missing);
  std::ifstream file(path, std::ios::binary);
  if (missing || !file) return;
  const std::optional<std::uint64_t> begin = Begin(file, file_bytes);
  if (!begin) return;
  std::string kept;  // of the block before: a signature may lie across two
  for (std::uint64_t at = *begin; at < file_bytes;) {
    const std::string block = ReadAt(file, at, kBlock);
    if (block.empty()) return;
    at += block.size();
    kept += block;
    for (std::size_t found = kept.find(kEntry); found != std::string::npos;
         found = kept.find(kEntry, found + kEntry.size())) {
      if (!take(file, at - kept.size() + found)) return;
    }
    kept.erase(0, kept.size() - std::min(kept.size(), kEntry.size() - 1));
  }
}

bool HasNul(const std::string& name) { return name.find('\0') != std::string::npos; }

// Where the file of an entry lies; its extra field has the place where 32 bits are too few (4.5.3).
std::uint64_t PlaceOfFile(std::string_view entry, std::string_view extra) {
  const std::uint64_t place = Little(entry, 42, 4);
  if (place != kIn64) return place;
  while (extra.size() >= 4) {
    const std::size_t size = std::min<std::size_t>(Little(extra, 2, 2), extra.size() - 4);
    const std::size_t at = (Little(entry, 24, 4) == kIn64 ? 8 : 0) + (Little(entry, 20, 4) == kIn64 ? 8 : 0);
    if (Little(extra, 0, 2) == 1 && at + 8 <= size) return Little(extra, 4 + at, 8);
    extra.remove_prefix(4 + size);
  }
  return place;
}

bool HasNameWithNul(std::ifstream& file, std::uint64_t at) {
  const std::string entry = ReadAt(file, at, kEntryBytes);
  if (entry.size() < kEntryBytes) return false;
  const std::size_t name_bytes = Little(entry, 28, 2);
  const std::string rest = ReadAt(file, at + kEntryBytes, name_bytes + Little(entry, 30, 2));
  if (HasNul(rest.substr(0, name_bytes))) return true;
  const std::uint64_t place =
      PlaceOfFile(entry, std::string_view(rest).substr(std::min(name_bytes, rest.size())));
  if (place >= at) return false;  // files lie before the directory
  const std::string local = ReadAt(file, place, kFileBytes);
  return local.size() == kFileBytes && local.starts_with(kFile) &&
         HasNul(ReadAt(file, place + kFileBytes, Little(local, 26, 2)));
}

}  // namespace

int CountZipEntries(const std::filesystem::path& path, int most) {
  int count = 0;
  ForEachEntry(path, [&](std::ifstream&, std::uint64_t) { return ++count <= most; });
  return count;
}

bool HasZipNameWithNul(const std::filesystem::path& path) {
  bool has_nul = false;
  ForEachEntry(path, [&](std::ifstream& file, std::uint64_t at) {
    has_nul = HasNameWithNul(file, at);
    return !has_nul;
  });
  return has_nul;
}

}  // namespace skyquilt::storage
