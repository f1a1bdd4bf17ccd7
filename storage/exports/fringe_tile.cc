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
  static_assert(kCoveredAlpha == 0x80, "the highest bit of alpha is the mask");
  for (int y = 0; y < canvas.width_px; ++y) {
    std::uint8_t* const bits = fringe.mask_bits.data() + static_cast<std::size_t>(y) * row_bytes;
    const std::uint8_t* const alpha = canvas.Pixel(0, y) + 3;
    std::uint8_t any = 0;
    for (std::size_t at = 0; at < row_bytes; ++at) {
      const std::size_t first = 8 * at, count = std::min<std::size_t>(8, canvas.width_px - first);
      unsigned eight = 0;
      for (std::size_t k = 0; k < count; ++k) eight |= (alpha[4 * (first + k)] & kCoveredAlpha) >> k;
      bits[at] = static_cast<std::uint8_t>(eight);
      any |= bits[at];
    }
    fringe.is_empty &= any == 0;
  }
  FillOutside(canvas);
  const std::vector<std::uint8_t> jpeg = image::EncodeJpeg(image::RowsOf(canvas), jpeg_quality);
  fringe.jpeg.assign(jpeg.begin(), jpeg.end());
  return fringe;
}

}  // namespace skyquilt::storage
