// libFuzzer: any bytes as a PNG of the size that its header says, whole, smaller and by a rectangle. Checked:
// what comes out has the size that was asked for, and the rectangle the pixels of the whole. The chunks'
// checksums are put right, or libpng would refuse nearly every change.
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <vector>

#include "core/base/check.h"
#include "core/image/png_decoder.h"

namespace {

std::uint32_t NumberAt(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return (std::uint32_t{bytes[at]} << 24) | (std::uint32_t{bytes[at + 1]} << 16) |
         (std::uint32_t{bytes[at + 2]} << 8) | bytes[at + 3];
}

void MendChecksums(std::vector<std::uint8_t>& png) {
  for (std::size_t at = 8; at + 12 <= png.size();) {  // length, kind, content, checksum
    const std::size_t length = NumberAt(png, at);
    if (length > png.size() - at - 12) return;
    const std::uint32_t sum =
        static_cast<std::uint32_t>(crc32(0, png.data() + at + 4, static_cast<uInt>(length + 4)));
    for (std::size_t i = 0; i < 4; ++i)
      png[at + 8 + length + i] = static_cast<std::uint8_t>(sum >> (24 - 8 * i));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  if (size < 26 || !image::IsPng({data, size})) return 0;
  std::vector<std::uint8_t> bytes(data, data + size);
  MendChecksums(bytes);
  const int width_px = static_cast<int>(NumberAt(bytes, 16)),
            height_px = static_cast<int>(NumberAt(bytes, 20));
  if (width_px < 1 || height_px < 1 || width_px > 2000 || height_px > 2000) return 0;
  const auto whole = image::DecodePng(bytes, width_px, height_px, 1, std::nullopt);
  (void)image::DecodePng(bytes, width_px, height_px, 4, std::nullopt);
  const image::PixelBox box{width_px / 3, height_px / 3, width_px / 2 + 1, height_px / 2 + 1};
  const auto part = image::DecodePng(bytes, width_px, height_px, 1, box);
  if (!whole || !part) return 0;
  SKYQUILT_CHECK(part->left_px == box.left && part->top_px == box.top, "another rectangle");
  for (int y = 0; y < part->image.height_px; ++y) {
    SKYQUILT_CHECK(std::memcmp(part->image.Row(y), whole->image.Row(y + box.top) + 3 * box.left,
                               3 * static_cast<std::size_t>(part->image.width_px)) == 0,
                   "a rectangle with other pixels");
  }
  return 0;
}
