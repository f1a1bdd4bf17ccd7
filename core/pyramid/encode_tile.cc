#include "core/pyramid/encode_tile.h"

#include <turbojpeg.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/base/check.h"
#include "core/pyramid/png_encoder.h"

namespace skyquilt::pyramid {
namespace {

enum class Coverage { kNone, kPartial, kFull };

// A square of an image.
struct Square {
  const RgbaImage& image;
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

std::vector<std::uint8_t> EncodeJpeg(const Square& tile, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed =
      tjCompress2(encoder.get(), tile.Row(0), tile.size_px, 4 * tile.image.width_px, tile.size_px, TJPF_RGBA,
                  &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG encoder: ") + tjGetErrorStr2(encoder.get()));
  return {bytes, bytes + size};
}

// OpenCV's encoder wants straight alpha, blue first.
std::vector<std::uint8_t> EncodeWebp(const Square& tile, int quality) {
  cv::Mat straight(tile.size_px, tile.size_px, CV_8UC4);
  for (int y = 0; y < tile.size_px; ++y)
    StraightenAlpha(tile.Row(y), tile.size_px, straight.ptr<std::uint8_t>(y));
  cv::cvtColor(straight, straight, cv::COLOR_RGBA2BGRA);
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".webp", straight, bytes, {cv::IMWRITE_WEBP_QUALITY, quality})) {
    throw std::runtime_error("no encoder for WebP");
  }
  return bytes;
}

}  // namespace

std::optional<EncodedTile> EncodeTile(const RgbaImage& image, int x, int y, int size_px,
                                      const EncodeOptions& options) {
  SKYQUILT_CHECK(
      size_px > 0 && x >= 0 && y >= 0 && x + size_px <= image.width_px && y + size_px <= image.height_px,
      "a tile beyond the image");
  const Square tile{image, x, y, size_px};
  const Coverage coverage = CoverageOf(tile);
  if (coverage == Coverage::kNone) return std::nullopt;
  if (options.use_webp) return EncodedTile{TileFormat::kWebp, EncodeWebp(tile, options.quality)};
  if (coverage == Coverage::kFull) return EncodedTile{TileFormat::kJpeg, EncodeJpeg(tile, options.quality)};
  return EncodedTile{TileFormat::kPng, EncodePng(image, x, y, size_px)};
}

std::optional<EncodedTile> EncodeTile(const RgbaImage& tile, const EncodeOptions& options) {
  SKYQUILT_CHECK(tile.width_px == tile.height_px, "tiles are squares");
  return EncodeTile(tile, 0, 0, tile.width_px, options);
}

}  // namespace skyquilt::pyramid
