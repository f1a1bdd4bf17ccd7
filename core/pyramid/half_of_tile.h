// HalfOfTile: what a stored tile gives to its parent: its picture at half its size, alpha premultiplied. Made
// from the stored bytes also where the pixels that they were made from are at hand, so that the parent is the
// same whether its children were rendered a moment ago or by an earlier run, of which only the tiles are
// left. Deterministic. Any thread. Errors: kCorrupt (bytes that are no tile of this size).
#pragma once

#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

Result<image::RgbaImage> HalfOfTile(std::span<const std::uint8_t> stored, int tile_size_px);

}  // namespace skyquilt::pyramid
