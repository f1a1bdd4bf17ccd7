#include "core/pyramid/tile_image.h"

#include <cstddef>
#include <cstring>
#include <string_view>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/base/vector_clones.h"
#include "core/image/picture_codec.h"

namespace skyquilt::pyramid {

namespace {

// One row from two: each pixel's four bytes in two halves, so that their sums have room.
SKYQUILT_VECTOR_CLONES void HalveRows(const std::uint8_t* upper, const std::uint8_t* lower, std::size_t count,
                                      std::uint8_t* __restrict out) {
  constexpr std::uint64_t kEveryOther = 0x00ff'00ff'00ff'00ff;
  constexpr std::uint32_t kOfOne = 0x00ff'00ff, kHalf = 0x0002'0002;
  for (std::size_t x = 0; x < count; ++x) {
    std::uint64_t above = 0, below = 0;
    std::memcpy(&above, upper + 8 * x, 8);
    std::memcpy(&below, lower + 8 * x, 8);
    const std::uint64_t even = (above & kEveryOther) + (below & kEveryOther);
    const std::uint64_t odd = (above >> 8 & kEveryOther) + (below >> 8 & kEveryOther);
    const auto even_sum = static_cast<std::uint32_t>(even + (even >> 32)) + kHalf;
    const auto odd_sum = static_cast<std::uint32_t>(odd + (odd >> 32)) + kHalf;
    const std::uint32_t pixel = (even_sum >> 2 & kOfOne) | (odd_sum >> 2 & kOfOne) << 8;
    std::memcpy(out + 4 * x, &pixel, 4);
  }
}

void PremultiplyAlpha(image::RgbaImage& straight) {
  for (std::size_t at = 0; at + 3 < straight.rgba.size(); at += 4) {
    std::uint8_t* pixel = straight.rgba.data() + at;
    const unsigned alpha = pixel[3];
    if (alpha == 255) continue;
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>((pixel[c] * alpha + 127) / 255);
  }
}

}  // namespace

image::RgbaImage Halve(const image::RgbaImage& image) {
  SKYQUILT_CHECK(image.width_px % 2 == 0 && image.height_px % 2 == 0, "only even images are halved");
  image::RgbaImage half{image.width_px / 2, image.height_px / 2, {}};
  half.rgba.resize(4 * static_cast<std::size_t>(half.width_px) * static_cast<std::size_t>(half.height_px));
  for (int y = 0; y < half.height_px; ++y) {
    HalveRows(image.Pixel(0, 2 * y), image.Pixel(0, 2 * y + 1), static_cast<std::size_t>(half.width_px),
              half.Pixel(0, y));
  }
  return half;
}

image::RgbaImage EveryOther(const image::RgbaImage& image) {
  SKYQUILT_CHECK(image.width_px % 2 == 0 && image.height_px % 2 == 0, "only even images are halved");
  image::RgbaImage half = image::RgbaImage::Transparent(image.width_px / 2, image.height_px / 2);
  for (int y = 0; y < half.height_px; ++y) {
    for (int x = 0; x < half.width_px; ++x) {
      const std::uint8_t* upper = image.Pixel(2 * x, 2 * y);
      const std::uint8_t* lower = image.Pixel(2 * x, 2 * y + 1);
      for (const std::uint8_t* pixel : {upper, upper + 4, lower, lower + 4}) {
        if (pixel[3] == 0) continue;
        std::memcpy(half.Pixel(x, y), pixel, 4);
        break;
      }
    }
  }
  return half;
}

void Paste(const image::RgbaImage& quarter, int x, int y, image::RgbaImage& image) {
  SKYQUILT_CHECK(x + quarter.width_px <= image.width_px && y + quarter.height_px <= image.height_px,
                 "paste outside the image");
  for (int row = 0; row < quarter.height_px; ++row) {
    std::memcpy(image.Pixel(x, y + row), quarter.Pixel(0, row),
                static_cast<std::size_t>(quarter.width_px) * 4);
  }
}

Result<image::RgbaImage> HalfOfTile(std::span<const std::uint8_t> stored, int tile_size_px) {
  SKYQUILT_TRY_ASSIGN(
      image::RgbaImage tile,
      image::DecodePicture(std::string_view(reinterpret_cast<const char*>(stored.data()), stored.size())));
  if (tile.width_px != tile_size_px || tile.height_px != tile_size_px) {
    return Error{ErrorCode::kCorrupt,
                 "A tile of the earlier map is damaged. Delete mosaic.state beside it and start again.", ""};
  }
  PremultiplyAlpha(tile);
  return Halve(tile);
}

}  // namespace skyquilt::pyramid
