// libFuzzer: any bytes as an XMP packet. Checked: every number that comes out is finite.
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "core/flight/metadata/attitude_tags.h"
#include "core/flight/metadata/position_tags.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photos/choose_intrinsics.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::flight;
  XmpTags xmp;
  xmp.AddPacket(std::string_view(reinterpret_cast<const char*>(bytes), size));
  std::vector<Remark> notes;
  if (const auto attitude = AttitudeFromTags(xmp, std::nullopt, "", notes)) {
    SKYQUILT_CHECK(std::isfinite(attitude->yaw_rad + attitude->pitch_rad + attitude->roll_rad),
                   "an endless angle");
  }
  if (const auto velocity = VelocityFromTags(xmp)) {
    SKYQUILT_CHECK(velocity->allFinite(), "an endless speed");
  }
  if (const auto turning = TurningFromTags(xmp, notes)) {
    SKYQUILT_CHECK(turning->samples.size() >= 2 && turning->samples.size() <= 4096,
                   "too few or many samples");
    for (std::size_t i = 0; i < turning->samples.size(); ++i) {
      const TurnRate& sample = turning->samples[i];
      SKYQUILT_CHECK(std::isfinite(sample.time_s) && sample.in_cam_radps.allFinite(), "an endless rate");
      SKYQUILT_CHECK(i == 0 || turning->samples[i - 1].time_s < sample.time_s, "time runs backwards");
    }
  }
  PositionFromTags({}, xmp, notes);
  SKYQUILT_CHECK(ChooseIntrinsics(4000, 3000, {}, xmp, notes).intrinsics.focal_x_px > 0.0, "no focal length");
  return 0;
}
