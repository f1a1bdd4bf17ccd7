#include "storage/exports/fringe_tile.h"

#include <algorithm>
#include <array>

#include "core/base/try.h"
#include "core/image/picture_codec.h"

namespace skyquilt::storage {
namespace {

constexpr std::uint8_t kCoveredAlpha = 128;

// What JPEG codes together with 4:2:0.
constexpr int kUnitPx = 16;

// Beyond the edge, but within its JPEG unit, the mean of the covered pixels; black farther out.
void FillOutside(image::RgbaImage& canvas) {
  for (int top = 0; top < canvas.width_px; top += kUnitPx) {
    for (int left = 0; left < canvas.width_px; left += kUnitPx) {
      const int bottom = std::min(top + kUnitPx, canvas.width_px),
                right = std::min(left + kUnitPx, canvas.width_px);
      int covered = 0;
      for (int y = top; y < bottom; ++y) {
        const std::uint8_t* alpha = canvas.Pixel(left, y) + 3;
        for (int x = left; x < right; ++x, alpha += 4) covered += *alpha >= kCoveredAlpha ? 1 : 0;
      }
      if (covered == (bottom - top) * (right - left)) continue;
      if (covered == 0) {
        for (int y = top; y < bottom; ++y)
          std::fill(canvas.Pixel(left, y), canvas.Pixel(right - 1, y) + 3, std::uint8_t{0});
        continue;
      }
      const auto visit = [&](auto&& act) {
        for (int y = top; y < bottom; ++y) {
          for (int x = left; x < right; ++x) act(canvas.Pixel(x, y));
        }
      };
      std::array<int, 3> sum{};
      visit([&](const std::uint8_t* pixel) {
        if (pixel[3] < kCoveredAlpha) return;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
      });
      visit([&](std::uint8_t* pixel) {
        if (pixel[3] >= kCoveredAlpha) return;
        for (std::size_t c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>((sum[c] + covered / 2) / covered);
      });
    }
  }
}

}  // namespace

Result<image::RgbaImage> DecodeTile(std::string_view bytes, int tile_size_px) {
  SKYQUILT_TRY_ASSIGN(image::RgbaImage tile, image::DecodePicture(bytes));
  if (tile.width_px != tile_size_px || tile.height_px != tile_size_px) {
    return Error{ErrorCode::kCorrupt,
                 "A stored tile has another size than its map says. Stitch the flight again.", ""};
  }
  return tile;
}

FringeTile SplitAlpha(image::RgbaImage canvas, int jpeg_quality) {
  FringeTile fringe;
  const std::size_t row_bytes = (static_cast<std::size_t>(canvas.width_px) + 7) / 8;
  fringe.mask_bits.assign(row_bytes * static_cast<std::size_t>(canvas.width_px), 0);
  for (int y = 0; y < canvas.width_px; ++y) {
    std::uint8_t* bits = fringe.mask_bits.data() + static_cast<std::size_t>(y) * row_bytes;
    for (int x = 0; x < canvas.width_px; ++x)
      bits[x / 8] |=
          static_cast<std::uint8_t>((canvas.Pixel(x, y)[3] >= kCoveredAlpha ? 0x80 : 0) >> (x % 8));
    fringe.is_empty &= std::all_of(bits, bits + row_bytes, [](std::uint8_t eight) { return eight == 0; });
  }
  FillOutside(canvas);
  const std::vector<std::uint8_t> jpeg = image::EncodeJpeg(image::RowsOf(canvas), jpeg_quality);
  fringe.jpeg.assign(jpeg.begin(), jpeg.end());
  return fringe;
}

}  // namespace skyquilt::storage
