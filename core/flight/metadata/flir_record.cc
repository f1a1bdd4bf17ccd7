#include "core/flight/metadata/flir_record.h"

#include <bit>
#include <cstring>
#include <optional>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kFlirHeaderBytes = 0x40, kFlirEntryBytes = 0x20, kPictureHeadBytes = 0x20;
constexpr std::uint32_t kMaxFlirEntries = 4096;
constexpr int kMaxLevelsSidePx = 4096;  // cameras have a quarter of it
constexpr std::uint16_t kPictureType = 0x01, kCameraType = 0x20;

Error DamagedRecord(const char* detail) {
  return Because(ErrorCode::kCorrupt, RemarkCode::kTemperaturesDamaged, detail);
}

using Bytes = std::span<const std::uint8_t>;

// Numbers in the byte order of a record.
struct Numbers {
  Bytes bytes;
  bool is_big_endian = false;

  std::uint64_t Unsigned(std::size_t at, std::size_t size) const {
    return at + size <= bytes.size() ? UnsignedAt(bytes.data() + at, size, is_big_endian) : 0;
  }
  double Float(std::size_t at) const {
    return std::bit_cast<float>(static_cast<std::uint32_t>(Unsigned(at, 4)));
  }
};

// Records begin with a small number, which tells their byte order.
Numbers NumbersOf(Bytes record, bool is_big_endian) {
  Numbers numbers{record, is_big_endian};
  if (numbers.Unsigned(0, 2) >= 0x100) numbers.is_big_endian = !is_big_endian;
  return numbers;
}

FlirConstants ConstantsOf(const Numbers& camera) {
  FlirConstants constants;
  constants.emissivity = camera.Float(0x20);
  constants.distance_m = camera.Float(0x24);
  constants.reflected_k = camera.Float(0x28);
  constants.atmosphere_k = camera.Float(0x2C);
  constants.window_k = camera.Float(0x30);
  constants.window_transmission = camera.Float(0x34);
  constants.relative_humidity = camera.Float(0x3C);
  constexpr double kPercentBeyond = 2.0;  // some write a share, some percents
  if (constants.relative_humidity > kPercentBeyond) constants.relative_humidity /= 100.0;
  constants.planck_r1 = camera.Float(0x58);
  constants.planck_b = camera.Float(0x5C);
  constants.planck_f = camera.Float(0x60);
  constants.alpha_1 = camera.Float(0x70);
  constants.alpha_2 = camera.Float(0x74);
  constants.beta_1 = camera.Float(0x78);
  constants.beta_2 = camera.Float(0x7C);
  constants.atmosphere_x = camera.Float(0x80);
  constants.planck_o = std::bit_cast<std::int32_t>(static_cast<std::uint32_t>(camera.Unsigned(0x308, 4)));
  constants.planck_r2 = camera.Float(0x30C);
  return constants;
}

// Whether the version says so; nothing where it says neither.
std::optional<bool> IsBigEndian(Bytes record) {
  for (const bool is_big_endian : {true, false}) {
    const std::uint64_t version = UnsignedAt(record.data() + 0x14, 4, is_big_endian);
    if (version >= 100 && version < 200) return is_big_endian;
  }
  return std::nullopt;
}

}  // namespace

Result<FlirRecord> ReadFlirRecord(Bytes record) {
  constexpr std::size_t kCameraBytes = 0x310;
  if (record.size() < kFlirHeaderBytes || (record[0] != 'F' && record[0] != 'A') ||
      std::memcmp(record.data() + 1, "FF\0", 3) != 0)
    return DamagedRecord("no FFF header");
  const std::optional<bool> is_big_endian = IsBigEndian(record);
  if (!is_big_endian) return DamagedRecord("an unknown version of FFF");
  const Numbers header{record, *is_big_endian};
  const std::uint64_t directory = header.Unsigned(0x18, 4), entries = header.Unsigned(0x1C, 4);
  if (entries > kMaxFlirEntries || directory + entries * kFlirEntryBytes > record.size())
    return DamagedRecord("the directory leaves the record");
  FlirRecord read;
  bool has_constants = false;
  for (std::uint64_t i = 0; i < entries; ++i) {
    const auto entry = static_cast<std::size_t>(directory + i * kFlirEntryBytes);
    const std::uint64_t type = header.Unsigned(entry, 2);
    const std::uint64_t begin = header.Unsigned(entry + 0x0C, 4), bytes = header.Unsigned(entry + 0x10, 4);
    const bool is_picture = type == kPictureType && read.picture.empty();
    const bool is_camera = type == kCameraType && !has_constants;
    if (!is_picture && !is_camera) continue;
    if (begin + bytes > record.size()) return DamagedRecord("an entry leaves the record");
    const Bytes content = record.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(bytes));
    if (content.size() <= (is_camera ? kCameraBytes - 1 : kPictureHeadBytes))
      return DamagedRecord("an entry is too short");
    const Numbers numbers = NumbersOf(content, *is_big_endian);
    if (is_camera) {
      read.constants = ConstantsOf(numbers);
      has_constants = true;
    } else {
      read.width_px = static_cast<int>(numbers.Unsigned(2, 2));
      read.height_px = static_cast<int>(numbers.Unsigned(4, 2));
      read.is_big_endian = numbers.is_big_endian;
      read.picture.assign(content.begin() + kPictureHeadBytes, content.end());
    }
  }
  if (!has_constants) return DamagedRecord("no constants of the camera");
  if (read.picture.empty() || read.width_px < 1 || read.height_px < 1 || read.width_px > kMaxLevelsSidePx ||
      read.height_px > kMaxLevelsSidePx)
    return DamagedRecord("no levels");
  return read;
}

Result<FlirRecord> ReadFlirRecord(ByteSource& source, const std::vector<FlirPart>& parts) {
  // Numbered by a byte: what is gathered stays below 256 segments.
  std::vector<const FlirPart*> in_order;
  for (const FlirPart& part : parts) {
    const std::size_t number = part.number;
    if (in_order.size() <= number) in_order.resize(number + 1, nullptr);
    if (in_order[number] == nullptr) in_order[number] = &part;
  }
  std::vector<std::uint8_t> record;
  for (const FlirPart* part : in_order) {
    if (part == nullptr || std::size_t{part->last} + 1 != in_order.size())
      return DamagedRecord("segments are missing");
    const auto bytes = source.ReadUpTo(part->offset, part->bytes);
    if (bytes.size() != part->bytes) return Because(ErrorCode::kIo, RemarkCode::kPhotoUnread);
    record.insert(record.end(), bytes.begin(), bytes.end());
  }
  return ReadFlirRecord(record);
}

}  // namespace skyquilt::flight
