// libFuzzer: any bytes as a PNG of the size that its header says, whole, smaller and by a rectangle. Checked:
// what comes out has the size that was asked for, and the rectangle the pixels of the whole.
#include <cstdint>
#include <cstring>

#include "core/base/check.h"
#include "core/flight/png_decoder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  if (size < 26 || !flight::IsPng({bytes, size})) return 0;
  const auto side = [&](std::size_t at) {
    return (bytes[at] << 24) | (bytes[at + 1] << 16) | (bytes[at + 2] << 8) | bytes[at + 3];
  };
  const int width_px = side(16), height_px = side(20);
  if (width_px < 1 || height_px < 1 || width_px > 2000 || height_px > 2000) return 0;
  const auto whole = flight::DecodePng({bytes, size}, width_px, height_px, 1, std::nullopt);
  (void)flight::DecodePng({bytes, size}, width_px, height_px, 4, std::nullopt);
  const pipeline::PixelBox box{width_px / 3, height_px / 3, width_px / 2 + 1, height_px / 2 + 1};
  const auto part = flight::DecodePng({bytes, size}, width_px, height_px, 1, box);
  if (!whole || !part) return 0;
  SKYQUILT_CHECK(part->left_px == box.left && part->top_px == box.top, "another rectangle");
  for (int y = 0; y < part->image.height_px; ++y) {
    SKYQUILT_CHECK(std::memcmp(part->image.Row(y), whole->image.Row(y + box.top) + 3 * box.left,
                               3 * static_cast<std::size_t>(part->image.width_px)) == 0,
                   "a rectangle with other pixels");
  }
  return 0;
}
