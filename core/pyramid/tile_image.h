// What becomes of the pixels of a tile on the way to the next zoom. Alpha is premultiplied, so that averaging
// at the map's edge neither darkens nor bleeds. Pure.
#pragma once

#include "core/image/rgba_image.h"

namespace skyquilt::pyramid {

// Half the size, each pixel the mean of four: what GDAL's "average" overviews do, in the stored (sRGB)
// values.
image::RgbaImage Halve(const image::RgbaImage& image);
// Half the size, one pixel of each four as it is (the first that is covered): for colours that are codes.
image::RgbaImage EveryOther(const image::RgbaImage& image);
// Writes `quarter` at (x, y) of `image`.
void Paste(const image::RgbaImage& quarter, int x, int y, image::RgbaImage& image);

}  // namespace skyquilt::pyramid
