#include "core/pyramid/encode_tile.h"

#include <array>
#include <cstddef>
#include <cstring>

#include "core/base/check.h"
#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "core/image/png_encoder.h"

namespace skyquilt::pyramid {
namespace {

enum class Coverage { kNone, kPartial, kFull };

// A square of an image.
struct Square {
  const image::RgbaImage& image;
  int x, y, size_px;

  const std::uint8_t* Row(int row) const { return image.Pixel(x, y + row); }
};

Coverage CoverageOf(const Square& tile) {
  std::uint32_t any = 0, all = ~std::uint32_t{0};
  for (int row = 0; row < tile.size_px; ++row) {
    const std::uint8_t* pixels = tile.Row(row);
    for (int x = 0; x < tile.size_px; ++x) {
      std::uint32_t pixel = 0;
      std::memcpy(&pixel, pixels + std::ptrdiff_t{4} * x, 4);
      any |= pixel;
      all &= pixel;
    }
  }
  const auto alpha_of = [](std::uint32_t pixel) {
    std::array<std::uint8_t, 4> bytes{};
    std::memcpy(bytes.data(), &pixel, 4);
    return bytes[3];
  };
  return alpha_of(all) == 255 ? Coverage::kFull : alpha_of(any) != 0 ? Coverage::kPartial : Coverage::kNone;
}

image::RgbaImage Straight(const Square& tile) {
  image::RgbaImage straight{tile.size_px, tile.size_px, {}};
  straight.rgba.resize(4 * static_cast<std::size_t>(tile.size_px) * static_cast<std::size_t>(tile.size_px));
  for (int y = 0; y < tile.size_px; ++y)
    image::StraightenAlpha(tile.Row(y), tile.size_px, straight.Pixel(0, y));
  return straight;
}

}  // namespace

std::optional<EncodedTile> EncodeTile(const image::RgbaImage& image, int x, int y, int size_px,
                                      const EncodeOptions& options) {
  SKYQUILT_CHECK(
      size_px > 0 && x >= 0 && y >= 0 && x + size_px <= image.width_px && y + size_px <= image.height_px,
      "a tile beyond the image");
  const Square tile{image, x, y, size_px};
  const Coverage coverage = CoverageOf(tile);
  if (coverage == Coverage::kNone) return std::nullopt;
  if (options.encoding == image::TileEncoding::kWebp) {
    return EncodedTile{image::PictureFormat::kWebp,
                       image::EncodeWebp(image::RowsOf(Straight(tile)), static_cast<float>(options.quality))};
  }
  if (coverage == Coverage::kFull) {
    const image::PixelRows rows{tile.Row(0), size_px, size_px, 4, 4 * image.width_px};
    return EncodedTile{image::PictureFormat::kJpeg, image::EncodeJpeg(rows, options.quality)};
  }
  if (options.encoding == image::TileEncoding::kJpegWebp)
    return EncodedTile{image::PictureFormat::kWebp, image::EncodeFringe(Straight(tile), options.quality)};
  return EncodedTile{image::PictureFormat::kPng, image::EncodePng(image, x, y, size_px)};
}

std::optional<EncodedTile> EncodeTile(const image::RgbaImage& tile, const EncodeOptions& options) {
  SKYQUILT_CHECK(tile.width_px == tile.height_px, "tiles are squares");
  return EncodeTile(tile, 0, 0, tile.width_px, options);
}

}  // namespace skyquilt::pyramid
