#include "core/flight/metadata/exif_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/try.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

double Integer(const std::uint8_t* p, std::size_t size, bool is_big_endian, bool is_signed) {
  const std::uint64_t value = UnsignedAt(p, size, is_big_endian);
  if (!is_signed) return static_cast<double>(value);
  const unsigned shift = 64 - 8 * static_cast<unsigned>(size);
  return static_cast<double>(static_cast<std::int64_t>(value << shift) >> shift);
}

// Bytes of one item; 0 for unknown types.
std::size_t ExifTypeSize(std::uint16_t type) {
  constexpr std::array<std::uint8_t, 19> kSizes = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  static_assert(kSizes.size() == static_cast<std::size_t>(ExifType::kIfd8) + 1);
  return type < kSizes.size() ? kSizes[type] : 0;
}

std::optional<double> Finite(double value) {
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

std::optional<ExifValue::Fraction> ExifValue::Rational(std::size_t i) const {
  const bool is_signed = type == static_cast<std::uint16_t>(ExifType::kSRational);
  if (!is_signed && type != static_cast<std::uint16_t>(ExifType::kRational)) return std::nullopt;
  if (i >= bytes.size() / 8) return std::nullopt;
  const std::uint8_t* p = bytes.data() + 8 * i;
  return Fraction{Integer(p, 4, is_big_endian, is_signed), Integer(p + 4, 4, is_big_endian, is_signed)};
}

std::optional<double> ExifValue::Number(std::size_t i) const {
  const std::size_t size = ExifTypeSize(type);
  if (size == 0 || i >= bytes.size() / size) return std::nullopt;
  const std::uint8_t* p = bytes.data() + size * i;
  switch (static_cast<ExifType>(type)) {
    case ExifType::kAscii:
    case ExifType::kUndefined:
      return std::nullopt;
    case ExifType::kRational:
    case ExifType::kSRational: {
      const auto fraction = Rational(i);
      if (!fraction || fraction->denominator == 0.0) return std::nullopt;
      return Finite(fraction->numerator / fraction->denominator);
    }
    case ExifType::kFloat:
      return Finite(std::bit_cast<float>(static_cast<std::uint32_t>(UnsignedAt(p, 4, is_big_endian))));
    case ExifType::kDouble:
      return Finite(std::bit_cast<double>(UnsignedAt(p, 8, is_big_endian)));
    case ExifType::kSByte:
    case ExifType::kSShort:
    case ExifType::kSLong:
    case ExifType::kSLong8:
      return Integer(p, size, is_big_endian, true);
    default:
      return Integer(p, size, is_big_endian, false);
  }
}

std::string ExifValue::Text() const {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    text.push_back(byte >= 0x20 && byte < 0x7F ? static_cast<char>(byte) : '?');
  }
  const auto first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

bool IsTiff(std::span<const std::uint8_t> head) {
  if (head.size() < 4) return false;
  const bool is_little = head[0] == 'I' && head[1] == 'I' && (head[2] == 42 || head[2] == 43) && head[3] == 0;
  const bool is_big = head[0] == 'M' && head[1] == 'M' && head[2] == 0 && (head[3] == 42 || head[3] == 43);
  return is_little || is_big;
}

bool IsGeoTiff(const ExifTable& table) {
  constexpr std::uint16_t kGeoKeyDirectory = 34735;
  return table.Find(ExifIfd::kImage, kGeoKeyDirectory) != nullptr;
}

const ExifValue* ExifTable::Find(ExifIfd ifd, std::uint16_t tag) const {
  const auto it = values_.find({ifd, tag});
  return it == values_.end() ? nullptr : &it->second;
}

std::optional<double> ExifTable::Number(ExifIfd ifd, std::uint16_t tag, std::size_t i) const {
  const ExifValue* value = Find(ifd, tag);
  return value ? value->Number(i) : std::nullopt;
}

std::string ExifTable::Text(ExifIfd ifd, std::uint16_t tag) const {
  const ExifValue* value = Find(ifd, tag);
  return value ? value->Text() : std::string();
}

// Our bounded walker over the directories of a TIFF file: first image, EXIF, GPS, and where asked the other
// images. Every directory is visited once, at most 1024 entries per directory, values above 1 MiB are
// skipped. Classic TIFF and BigTIFF. Source: TIFF 6.0, section 2; BigTIFF as described by libtiff.
namespace {

constexpr std::uint64_t kMaxEntries = 1024;
constexpr std::uint64_t kMaxValueBytes = 1u << 20;
constexpr std::uint64_t kMaxTotalBytes = 8u << 20;
constexpr double kLargestOffset = 1e18;  // files end before
constexpr std::uint16_t kExifPointer = 0x8769;
constexpr std::uint16_t kGpsPointer = 0x8825;
constexpr std::uint16_t kSubIfdPointers = 0x014A;

class TiffWalker {
 public:
  TiffWalker(ByteSource& source, bool is_big_endian, bool is_big_tiff)
      : source_(source), is_big_endian_(is_big_endian), is_big_tiff_(is_big_tiff) {}

  std::optional<std::uint64_t> Unsigned(std::uint64_t offset, std::size_t size) {
    std::uint8_t bytes[8];
    if (!source_.Read(offset, std::span(bytes, size))) return std::nullopt;
    return UnsignedAt(bytes, size, is_big_endian_);
  }

  // Of the next directory in the chain; 0 at its end, or where the file ends before.
  std::uint64_t NextAfter(std::uint64_t offset) {
    const std::size_t count_size = is_big_tiff_ ? 8 : 2;
    const auto count = Unsigned(offset, count_size);
    if (!count || *count > (std::uint64_t{1} << 32)) return 0;
    return Unsigned(offset + count_size + *count * (is_big_tiff_ ? 20 : 12), is_big_tiff_ ? 8 : 4)
        .value_or(0);
  }

  // False when not a single entry could be read.
  bool ReadDirectory(std::uint64_t offset, ExifIfd ifd, ExifTable& table) {
    if (!visited_.insert(offset).second) return false;
    const auto count = Unsigned(offset, is_big_tiff_ ? 8 : 2);
    if (!count || *count == 0 || *count > kMaxEntries) return false;
    const std::size_t entry_size = is_big_tiff_ ? 20 : 12;
    const std::uint64_t first = offset + (is_big_tiff_ ? 8 : 2);
    const std::vector<std::uint8_t> entries =
        source_.ReadUpTo(first, static_cast<std::size_t>(*count) * entry_size);
    for (std::size_t i = 0; (i + 1) * entry_size <= entries.size(); ++i) {
      ReadEntry(entries.data() + i * entry_size, first + i * entry_size, ifd, table);
    }
    return entries.size() >= entry_size;
  }

 private:
  void ReadEntry(const std::uint8_t* entry, std::uint64_t entry_offset, ExifIfd ifd, ExifTable& table) {
    const auto number = [&](const std::uint8_t* p, std::size_t size) {
      return UnsignedAt(p, size, is_big_endian_);
    };
    const auto tag = static_cast<std::uint16_t>(number(entry, 2));
    ExifValue value;
    value.type = static_cast<std::uint16_t>(number(entry + 2, 2));
    value.is_big_endian = is_big_endian_;
    const std::size_t field = is_big_tiff_ ? 8 : 4;
    const std::uint64_t count = number(entry + 4, field);
    const std::size_t size = ExifTypeSize(value.type);
    if (size == 0 || count == 0 || count > kMaxValueBytes / size) return;
    value.count = static_cast<std::uint32_t>(count);
    const std::uint64_t total = count * size;
    const std::uint8_t* inline_bytes = entry + 4 + field;
    value.offset = total <= field ? entry_offset + 4 + field : number(inline_bytes, field);
    if (total <= field) {
      value.bytes.assign(inline_bytes, inline_bytes + total);
    } else {
      if (total > kMaxTotalBytes - total_bytes_) return;
      value.bytes.resize(static_cast<std::size_t>(total));
      if (!source_.Read(value.offset, value.bytes)) return;
      total_bytes_ += total;
    }
    if (table.Find(ifd, tag) == nullptr) table.Set(ifd, tag, std::move(value));
  }

  ByteSource& source_;
  bool is_big_endian_;
  bool is_big_tiff_;
  std::uint64_t total_bytes_ = 0;
  std::set<std::uint64_t> visited_;
};

Error Damaged(const char* detail) {
  return Because(ErrorCode::kCorrupt, RemarkCode::kTiffTagsDamaged, detail);
}

struct TiffStart {
  TiffWalker walker;
  std::optional<std::uint64_t> first;  // directory
};

Result<TiffStart> ReadStart(ByteSource& source) {
  std::uint8_t head[4];
  if (!source.Read(0, head)) return Damaged("shorter than its header");
  const bool is_big_endian = head[0] == 'M';
  if (head[0] != head[1] || (head[0] != 'M' && head[0] != 'I')) {
    return Because(ErrorCode::kUnsupportedFormat, RemarkCode::kIsNoPicture);
  }
  const int magic = is_big_endian ? head[2] * 256 + head[3] : head[3] * 256 + head[2];
  if (magic != 42 && magic != 43) return Because(ErrorCode::kUnsupportedFormat, RemarkCode::kIsNoPicture);
  TiffWalker walker(source, is_big_endian, magic == 43);
  const auto first = magic == 43 ? walker.Unsigned(8, 8) : walker.Unsigned(4, 4);
  return TiffStart{std::move(walker), first};
}

}  // namespace

Result<int> CountTiffDirectories(ByteSource& source, int most) {
  SKYQUILT_TRY_ASSIGN(TiffStart start, ReadStart(source));
  int count = 0;
  for (std::uint64_t at = start.first.value_or(0); at != 0 && count <= most; ++count)
    at = start.walker.NextAfter(at);
  return count;
}

Result<ExifTable> ReadTiffTags(ByteSource& source) {
  SKYQUILT_TRY_ASSIGN(TiffStart start, ReadStart(source));
  TiffWalker& walker = start.walker;
  const std::optional<std::uint64_t>& first = start.first;
  ExifTable table;
  if (!first || !walker.ReadDirectory(*first, ExifIfd::kImage, table)) return Damaged("first directory");
  for (const auto& [pointer, ifd] : {std::pair{kExifPointer, ExifIfd::kExif}, {kGpsPointer, ExifIfd::kGps}}) {
    const auto offset = table.Number(ExifIfd::kImage, pointer);
    if (offset && *offset > 0.0 && *offset < kLargestOffset)
      walker.ReadDirectory(static_cast<std::uint64_t>(*offset), ifd, table);
  }
  return table;
}

std::vector<ExifTable> ReadTiffPictures(ByteSource& source, int most) {
  auto start = ReadStart(source);
  std::vector<ExifTable> pictures;
  if (!start) return pictures;
  // True where there was a new one.
  const auto read = [&](std::uint64_t offset) {
    ExifTable table;
    if (std::ssize(pictures) >= most || !start->walker.ReadDirectory(offset, ExifIfd::kImage, table))
      return false;
    pictures.push_back(std::move(table));
    return true;
  };
  const std::uint64_t first = start->first.value_or(0);
  if (first == 0 || !read(first)) return pictures;
  if (const ExifValue* below = pictures.front().Find(ExifIfd::kImage, kSubIfdPointers)) {
    const ExifValue offsets = *below;
    for (std::size_t i = 0; i < std::min<std::size_t>(offsets.count, static_cast<std::size_t>(most)); ++i)
      read(static_cast<std::uint64_t>(std::clamp(offsets.Number(i).value_or(0.0), 0.0, kLargestOffset)));
  }
  for (std::uint64_t at = start->walker.NextAfter(first); at != 0 && read(at);)
    at = start->walker.NextAfter(at);
  return pictures;
}

// libexif is not used on what others made: it copies the values of each entry, however many entries share
// them, which makes gigabytes of 64 KiB, and reads the notes of every maker.
ExifTable ReadExifSegment(std::span<const std::uint8_t> tiff_block) {
  constexpr std::size_t kMaxSegment = 1 << 16;
  if (tiff_block.size() < 8 || tiff_block.size() > kMaxSegment) return {};
  MemoryBytes source(tiff_block);
  Result<ExifTable> table = ReadTiffTags(source);
  return table ? *std::move(table) : ExifTable();
}

}  // namespace skyquilt::flight
