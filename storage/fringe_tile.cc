#include "storage/fringe_tile.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace skyquilt::storage {
namespace {

constexpr int kChannels = 4;
constexpr std::uint8_t kCoveredAlpha = 128;

struct Canvas {
  int side_px = 0;
  std::vector<std::uint8_t> rgba;
  std::uint8_t* Row(int y) { return rgba.data() + static_cast<std::size_t>(y) * side_px * kChannels; }
};

// What JPEG codes together with 4:2:0.
constexpr int kUnitPx = 16;

// Beyond the edge, but within its JPEG unit, the mean of the covered pixels; black farther out.
void FillOutside(Canvas& canvas) {
  for (int top = 0; top < canvas.side_px; top += kUnitPx) {
    for (int left = 0; left < canvas.side_px; left += kUnitPx) {
      const int bottom = std::min(top + kUnitPx, canvas.side_px), right = std::min(left + kUnitPx, canvas.side_px);
      std::array<int, 3> sum{};
      int covered = 0;
      const auto visit = [&](auto&& act) {
        for (int y = top; y < bottom; ++y) {
          for (int x = left; x < right; ++x) act(canvas.Row(y) + x * kChannels);
        }
      };
      visit([&](const std::uint8_t* pixel) {
        if (pixel[3] < kCoveredAlpha) return;
        ++covered;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
      });
      visit([&](std::uint8_t* pixel) {
        if (pixel[3] >= kCoveredAlpha) return;
        for (std::size_t c = 0; c < 3; ++c) {
          pixel[c] = covered == 0 ? 0 : static_cast<std::uint8_t>((sum[c] + covered / 2) / covered);
        }
      });
    }
  }
}

std::string EncodeJpeg(const Canvas& canvas, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(encoder.get(), canvas.rgba.data(), canvas.side_px, 0, canvas.side_px,
                                 TJPF_RGBA, &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG encoder: ") + tjGetErrorStr2(encoder.get()));
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

Result<FringeTile> SplitAlpha(std::string_view png, int tile_size_px, int jpeg_quality) {
  const Error damaged{ErrorCode::kCorrupt, "a stored tile is damaged; stitch the flight again", ""};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return damaged;
  const auto side = static_cast<png_uint_32>(tile_size_px);
  if (image.width != side || image.height != side) {
    png_image_free(&image);
    return damaged;
  }
  image.format = PNG_FORMAT_RGBA;
  Canvas canvas{tile_size_px, std::vector<std::uint8_t>(static_cast<std::size_t>(side) * side * kChannels)};
  if (png_image_finish_read(&image, nullptr, canvas.rgba.data(), 0, nullptr) == 0) return damaged;

  FringeTile fringe;
  const std::size_t row_bytes = (side + 7) / 8;
  fringe.mask_bits.assign(row_bytes * side, 0);
  for (int y = 0; y < tile_size_px; ++y) {
    const std::uint8_t* row = canvas.Row(y);
    for (int x = 0; x < tile_size_px; ++x) {
      if (row[x * kChannels + 3] < kCoveredAlpha) continue;
      fringe.mask_bits[static_cast<std::size_t>(y) * row_bytes + static_cast<std::size_t>(x) / 8] |=
          static_cast<std::uint8_t>(0x80 >> (x % 8));
    }
  }
  FillOutside(canvas);
  fringe.jpeg = EncodeJpeg(canvas, jpeg_quality);
  return fringe;
}

}  // namespace skyquilt::storage
