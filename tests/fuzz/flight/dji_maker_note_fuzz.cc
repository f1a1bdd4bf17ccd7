// libFuzzer: any bytes as DJI's maker note, in both byte orders. Checked: every number is finite.
#include <cmath>
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/metadata/attitude_tags.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  for (const bool is_big_endian : {false, true}) {
    const auto note = skyquilt::flight::ReadDjiMakerNote({bytes, size}, is_big_endian);
    if (!note) continue;
    for (const auto& value : {note->pitch_deg, note->yaw_deg, note->camera_pitch_deg}) {
      SKYQUILT_CHECK(std::isfinite(value.value_or(0.0)), "an endless number");
    }
  }
  return 0;
}
