// libFuzzer: any bytes as a photo's file. Checked: what is accepted has a size and a lens one can compute
// with.
#include <cstdint>

#include "core/base/check.h"
#include "core/flight/photos/read_photo.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto photo = skyquilt::flight::ReadPhotoFromBytes("fuzzed.jpg", {bytes, size});
  if (!photo) {
    SKYQUILT_CHECK(!photo.error().message.empty(), "a refusal without a reason");
    return 0;
  }
  SKYQUILT_CHECK(
      photo->intrinsics.width_px > 0 && photo->intrinsics.width_px <= skyquilt::flight::kMaxPhotoSidePx,
      "an impossible width");
  SKYQUILT_CHECK(photo->intrinsics.focal_x_px > 0.0, "no focal length");
  return 0;
}
