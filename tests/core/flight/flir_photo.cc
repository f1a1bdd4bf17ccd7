#include "tests/core/flight/flir_photo.h"

#include <algorithm>
#include <bit>
#include <string_view>

namespace skyquilt::flight {
namespace {

void PutAt(Bytes& bytes, std::size_t at, std::uint64_t value, std::size_t size, bool is_big_endian) {
  if (bytes.size() < at + size) bytes.resize(at + size, 0);
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t byte = is_big_endian ? size - 1 - i : i;
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * byte));
  }
}

Bytes CameraEntry(const FlirConstants& constants, bool is_big_endian) {
  Bytes entry(0x400, 0);
  PutAt(entry, 0, 2, 2, is_big_endian);
  const auto put = [&](std::size_t at, double value) {
    PutAt(entry, at, std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4, is_big_endian);
  };
  put(0x20, constants.emissivity);
  put(0x24, constants.distance_m);
  put(0x28, constants.reflected_k);
  put(0x2C, constants.atmosphere_k);
  put(0x30, constants.window_k);
  put(0x34, constants.window_transmission);
  put(0x3C, constants.relative_humidity);
  put(0x58, constants.planck_r1);
  put(0x5C, constants.planck_b);
  put(0x60, constants.planck_f);
  put(0x70, constants.alpha_1);
  put(0x74, constants.alpha_2);
  put(0x78, constants.beta_1);
  put(0x7C, constants.beta_2);
  put(0x80, constants.atmosphere_x);
  PutAt(entry, 0x308, static_cast<std::uint32_t>(static_cast<std::int32_t>(constants.planck_o)), 4,
        is_big_endian);
  put(0x30C, constants.planck_r2);
  return entry;
}

Bytes PictureEntry(const FlirPhoto& photo) {
  const bool is_big_endian = photo.kind == FlirLevels::kBigEndian;
  Bytes entry(0x20, 0);
  PutAt(entry, 0, 2, 2, is_big_endian);
  PutAt(entry, 2, static_cast<std::uint64_t>(photo.width_px), 2, is_big_endian);
  PutAt(entry, 4, static_cast<std::uint64_t>(photo.height_px), 2, is_big_endian);
  if (photo.kind == FlirLevels::kPng) {
    entry.insert(entry.end(), photo.png.begin(), photo.png.end());
  } else {
    for (const std::uint16_t level : photo.levels) PutAt(entry, entry.size(), level, 2, is_big_endian);
  }
  return entry;
}

}  // namespace

FlirConstants UsualFlirConstants() {
  FlirConstants constants;
  constants.planck_r1 = 17096.453;
  constants.planck_r2 = 0.046642166;
  constants.planck_b = 1428.0;
  constants.planck_f = 1.0;
  constants.planck_o = -342;
  constants.emissivity = 0.95;
  constants.distance_m = 50.0;
  constants.reflected_k = 268.15;
  constants.atmosphere_k = 293.15;
  constants.window_k = 295.15;
  constants.window_transmission = 0.97;
  constants.relative_humidity = 0.5;
  constants.alpha_1 = 0.006569;
  constants.alpha_2 = 0.01262;
  constants.beta_1 = -0.002276;
  constants.beta_2 = -0.00667;
  constants.atmosphere_x = 1.9;
  return constants;
}

Bytes FlirRecordBytes(const FlirPhoto& photo) {
  const bool is_big_endian = photo.is_big_endian;
  const Bytes picture = PictureEntry(photo), camera = CameraEntry(photo.constants, is_big_endian);
  constexpr std::size_t kDirectory = 0x40, kEntry = 0x20, kEntries = 3;
  const std::size_t picture_at = kDirectory + kEntries * kEntry, camera_at = picture_at + picture.size();
  Bytes record{'F', 'F', 'F', 0, 'T', 'E', 'S', 'T'};
  record.resize(kDirectory, 0);
  PutAt(record, 0x14, 101, 4, is_big_endian);
  PutAt(record, 0x18, kDirectory, 4, is_big_endian);
  PutAt(record, 0x1C, kEntries, 4, is_big_endian);
  const auto put_entry = [&](std::size_t i, std::uint16_t type, std::size_t at, std::size_t bytes) {
    PutAt(record, kDirectory + i * kEntry, type, 2, is_big_endian);
    PutAt(record, kDirectory + i * kEntry + 0x0C, at, 4, is_big_endian);
    PutAt(record, kDirectory + i * kEntry + 0x10, bytes, 4, is_big_endian);
  };
  put_entry(0, 0, 0, 0);  // cameras leave free ones
  put_entry(1, 0x01, picture_at, picture.size());
  put_entry(2, 0x20, camera_at, camera.size());
  record.resize(picture_at, 0);
  record.insert(record.end(), picture.begin(), picture.end());
  record.insert(record.end(), camera.begin(), camera.end());
  return record;
}

Bytes WithFlirRecord(const Bytes& jpeg, const Bytes& record, std::size_t part_bytes) {
  Bytes photo(jpeg.begin(), jpeg.begin() + 2);
  const std::size_t parts = (record.size() + part_bytes - 1) / part_bytes;
  for (std::size_t i = 0; i < parts; ++i) {
    const std::size_t begin = i * part_bytes, bytes = std::min(part_bytes, record.size() - begin);
    const Bytes head{0xFF, 0xE1, static_cast<std::uint8_t>((bytes + 10) >> 8),
                     static_cast<std::uint8_t>(bytes + 10)};
    photo.insert(photo.end(), head.begin(), head.end());
    constexpr std::string_view kName("FLIR\0\1", 6);
    photo.insert(photo.end(), kName.begin(), kName.end());
    photo.push_back(static_cast<std::uint8_t>(i));
    photo.push_back(static_cast<std::uint8_t>(parts - 1));
    photo.insert(photo.end(), record.begin() + static_cast<std::ptrdiff_t>(begin),
                 record.begin() + static_cast<std::ptrdiff_t>(begin + bytes));
  }
  photo.insert(photo.end(), jpeg.begin() + 2, jpeg.end());
  return photo;
}

}  // namespace skyquilt::flight
