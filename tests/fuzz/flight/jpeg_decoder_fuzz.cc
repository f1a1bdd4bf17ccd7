// libFuzzer: five bytes that ask for a size and a rectangle, then any bytes as a JPEG. Checked: what comes
// back holds what was asked for, and nothing is written beyond it.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/check.h"
#include "core/flight/photos/image_header.h"
#include "core/image/jpeg_decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  constexpr std::size_t kAsked = 5;
  constexpr int kMaxSidePx = 2048;  // larger ones only take longer
  if (size < kAsked) return 0;
  const std::uint8_t* const jpeg = bytes + kAsked;
  flight::MemoryBytes source({jpeg, size - kAsked});
  const auto header = flight::ReadImageHeader(source);
  if (!header || header->width_px > kMaxSidePx || header->height_px > kMaxSidePx) return 0;
  const int denominator = 1 << (bytes[0] % 4);
  const int width_px = (header->width_px + denominator - 1) / denominator;
  const int height_px = (header->height_px + denominator - 1) / denominator;
  image::PixelBox box{bytes[1] * width_px / 256, bytes[2] * height_px / 256, 0, 0};
  box.right = box.left + 1 + bytes[3] * (width_px - box.left - 1) / 255;
  box.bottom = box.top + 1 + bytes[4] * (height_px - box.top - 1) / 255;
  const auto part =
      image::DecodeJpeg({jpeg, size - kAsked}, header->width_px, header->height_px, denominator, box, {});
  if (!part) {
    SKYQUILT_CHECK(!part.error().message.empty(), "a refusal without a reason");
    return 0;
  }
  const image::DecodedImage& image = part->image;
  SKYQUILT_CHECK((image::PixelBox{part->left_px, part->top_px, part->left_px + image.width_px,
                                  part->top_px + image.height_px}
                      .Contains(box)),
                 "less than was asked for");
  SKYQUILT_CHECK(image.rgb.size() == static_cast<std::size_t>(image.width_px) * image.height_px * 3,
                 "not as many pixels as it says");
  return 0;
}
