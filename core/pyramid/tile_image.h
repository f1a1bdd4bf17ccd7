// What becomes of the pixels of a tile on the way to the next zoom. Alpha is premultiplied, so that averaging
// at the map's edge neither darkens nor bleeds. Pure; deterministic; any thread.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

// Half the size, each pixel the mean of four: what GDAL's "average" overviews do, in the stored (sRGB)
// values.
image::RgbaImage Halve(const image::RgbaImage& image);
// Half the size, one pixel of each four as it is (the first that is covered): for colours that are codes.
image::RgbaImage EveryOther(const image::RgbaImage& image);
// Writes `quarter` at (x, y) of `image`.
void Paste(const image::RgbaImage& quarter, int x, int y, image::RgbaImage& image);

// What a stored tile gives to its parent: its picture at half its size, alpha premultiplied. Made
// from the stored bytes also where the pixels that they were made from are at hand, so that the parent is the
// same whether its children were rendered a moment ago or by an earlier run, of which only the tiles are
// left. Errors: kCorrupt (bytes that are no tile of this size).
Result<image::RgbaImage> HalfOfTile(std::span<const std::uint8_t> stored, int tile_size_px);

}  // namespace skyquilt::pyramid
