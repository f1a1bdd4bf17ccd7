// EncodeTile: a premultiplied tile to the bytes that are stored and served: JPEG where every pixel is
// covered, PNG with alpha at the fringe (or WebP for both). Deterministic. Any thread; each call uses its own
// encoder.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/pyramid/tile_image.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::pyramid {

struct EncodeOptions {
  bool use_webp = false;
  int quality = 85;
};

struct EncodedTile {
  TileFormat format = TileFormat::kJpeg;
  std::vector<std::uint8_t> bytes;
};

// The square of `image` that starts at (x, y); nothing if no pixel of it is covered.
std::optional<EncodedTile> EncodeTile(const RgbaImage& image, int x, int y, int size_px,
                                      const EncodeOptions& options);
std::optional<EncodedTile> EncodeTile(const RgbaImage& tile, const EncodeOptions& options);

}  // namespace skyquilt::pyramid
