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
  std::vector<std::string> notes;
  if (const auto attitude = AttitudeFromTags(xmp, std::nullopt, "", notes)) {
    SKYQUILT_CHECK(std::isfinite(attitude->yaw_rad + attitude->pitch_rad + attitude->roll_rad),
                   "an endless angle");
  }
  if (const auto velocity = VelocityFromTags(xmp)) {
    SKYQUILT_CHECK(std::isfinite(velocity->east_mps + velocity->north_mps + velocity->up_mps),
                   "an endless speed");
  }
  PositionFromTags({}, xmp, notes);
  SKYQUILT_CHECK(ChooseIntrinsics(4000, 3000, {}, xmp, notes).intrinsics.focal_x_px > 0.0, "no focal length");
  return 0;
}
