// FringeTile: a tile for formats without alpha: opaque JPEG colours and one bit of mask per pixel. Colours
// are extended beyond the edge, so that JPEG neither darkens nor rings at the map's border. Pure. Errors:
// kCorrupt.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::storage {

// A stored tile of tile_size_px a side.
Result<image::RgbaImage> DecodeTile(std::string_view bytes, int tile_size_px);

struct FringeTile {
  std::string jpeg;                     // 4:2:0
  std::vector<std::uint8_t> mask_bits;  // rows padded to bytes, the first pixel in the highest bit
  bool is_empty = true;                 // nothing is covered
};

// Pixels of at least half alpha count as covered.
FringeTile SplitAlpha(image::RgbaImage tile, int jpeg_quality);

}  // namespace skyquilt::storage
