// The angles in DJI's maker note: floats that older models write beside, or instead of, XMP. A few lines of
// our own; bounded to the note's bytes. Degrees as found; camera pitch 0 = horizon. Any thread. Source: the
// tag list of ExifTool's documentation (DJI tags 0x06..0x0b).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace skyquilt::flight {

struct DjiMakerNote {
  std::optional<double> pitch_deg, yaw_deg, roll_deg;
  std::optional<double> camera_pitch_deg, camera_yaw_deg, camera_roll_deg;
};

// `note` is the value of EXIF tag 0x927C: a TIFF directory without a header of its own, which keeps the
// camera's byte order when a program writes the EXIF block around it anew in the other; the order of the EXIF
// is tried first. Nothing when it is not DJI's.
std::optional<DjiMakerNote> ReadDjiMakerNote(std::span<const std::uint8_t> note, bool exif_is_big_endian);

}  // namespace skyquilt::flight
