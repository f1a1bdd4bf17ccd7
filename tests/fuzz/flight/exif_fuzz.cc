// libFuzzer: any bytes as an EXIF segment and as a TIFF file. Checked: what is read is within its bounds.
#include <cmath>
#include <cstdint>
#include <span>

#include "core/base/check.h"
#include "core/flight/metadata/exif.h"

namespace {

void Interpret(const skyquilt::flight::ExifTable& table) {
  const auto record = skyquilt::flight::InterpretExif(table);
  if (record.position) {
    SKYQUILT_CHECK(std::abs(record.position->lat_deg) <= 90.0 && std::abs(record.position->lon_deg) <= 180.0,
                   "a position outside the Earth");
  }
  if (record.focal_length_mm)
    SKYQUILT_CHECK(*record.focal_length_mm > 0.0, "a focal length that is not positive");
  if (record.image_direction_deg) {
    SKYQUILT_CHECK(*record.image_direction_deg >= 0.0 && *record.image_direction_deg < 360.0,
                   "a direction outside the circle");
  }
  for (const auto& [key, value] : table.values()) {
    SKYQUILT_CHECK(value.Text().size() <= value.bytes.size(), "a text longer than its bytes");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::span input(bytes, size);
  Interpret(skyquilt::flight::ReadExifSegment(input));
  skyquilt::flight::MemoryBytes source(input);
  if (const auto table = skyquilt::flight::ReadTiffTags(source)) Interpret(*table);
  return 0;
}
