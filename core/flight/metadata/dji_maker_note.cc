#include "core/flight/metadata/dji_maker_note.h"

#include <bit>
#include <cmath>

#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {
namespace {

std::optional<DjiMakerNote> ReadInOrder(std::span<const std::uint8_t> note, bool is_big_endian) {
  constexpr std::uint32_t kMaxEntries = 100;
  constexpr std::uint32_t kFloat = 11;
  if (note.size() < 2) return std::nullopt;
  const std::uint64_t count = UnsignedAt(note.data(), 2, is_big_endian);
  if (count == 0 || count > kMaxEntries || note.size() < 2 + 12 * std::size_t{count}) return std::nullopt;
  DjiMakerNote found;
  std::optional<double>* const fields[] = {&found.pitch_deg,      &found.yaw_deg,
                                           &found.roll_deg,       &found.camera_pitch_deg,
                                           &found.camera_yaw_deg, &found.camera_roll_deg};
  constexpr std::uint32_t kFirstTag = 6;
  bool any = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint8_t* entry = note.data() + 2 + 12 * std::size_t{i};
    const std::uint64_t tag = UnsignedAt(entry, 2, is_big_endian);
    if (tag < kFirstTag || tag >= kFirstTag + std::size(fields)) continue;
    if (UnsignedAt(entry + 2, 2, is_big_endian) != kFloat || UnsignedAt(entry + 4, 4, is_big_endian) != 1)
      continue;
    const float value =
        std::bit_cast<float>(static_cast<std::uint32_t>(UnsignedAt(entry + 8, 4, is_big_endian)));
    if (!std::isfinite(value) || std::abs(value) > 1000.0f) continue;
    *fields[tag - kFirstTag] = static_cast<double>(value);
    any = true;
  }
  if (!any) return std::nullopt;
  return found;
}

}  // namespace

std::optional<DjiMakerNote> ReadDjiMakerNote(std::span<const std::uint8_t> note, bool exif_is_big_endian) {
  // Read the wrong way round, the number of entries or the type of each is nonsense: one order fits at most.
  if (auto found = ReadInOrder(note, exif_is_big_endian)) return found;
  return ReadInOrder(note, !exif_is_big_endian);
}

}  // namespace skyquilt::flight
