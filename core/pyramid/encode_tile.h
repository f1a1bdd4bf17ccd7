// EncodeTile: a premultiplied tile to the bytes that are stored and served: JPEG where every pixel is
// covered, at the fringe WebP with colours nearly as good and alpha without loss, or a PNG without
// any loss (or WebP for both). Deterministic. Any thread; each call uses its own encoder.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/image/picture_format.h"
#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

struct EncodeOptions {
  image::TileEncoding encoding = image::TileEncoding::kJpegWebp;
  int quality = 85;  // of JPEG, and of WebP throughout
};

struct EncodedTile {
  image::PictureFormat format = image::PictureFormat::kJpeg;
  std::vector<std::uint8_t> bytes;
};

// The square of `image` that starts at (x, y); nothing if no pixel of it is covered.
std::optional<EncodedTile> EncodeTile(const image::RgbaImage& image, int x, int y, int size_px,
                                      const EncodeOptions& options);
std::optional<EncodedTile> EncodeTile(const image::RgbaImage& tile, const EncodeOptions& options);

}  // namespace skyquilt::pyramid
