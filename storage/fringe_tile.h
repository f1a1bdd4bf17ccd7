// FringeTile: a partly transparent tile as formats without alpha hold it: opaque JPEG colours and one bit of
// mask a pixel. Beyond the edge the colours go on, so that JPEG neither darkens nor rings at the map's
// border. Pure; any thread. Errors: kCorrupt.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

struct FringeTile {
  std::string jpeg;                     // 4:2:0
  std::vector<std::uint8_t> mask_bits;  // rows padded to bytes, the first pixel in the highest bit
};

// From a PNG of tile_size_px a side.
Result<FringeTile> SplitAlpha(std::string_view png, int tile_size_px, int jpeg_quality);

}  // namespace skyquilt::storage
