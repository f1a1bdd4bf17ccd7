// ShrinkPicture: a picture in fewer pixels, each the mean of what it covers, weighted by area and by alpha,
// so that what is transparent colours nothing. Straight alpha in and out. Pure; any thread.
#pragma once

#include "core/image/rgba_image.h"

namespace skyquilt::image {

// Its longer side becomes `longer_side_px` (at least 1), the other in proportion and at least one pixel. One
// that is no larger stays as it is.
RgbaImage ShrinkPicture(RgbaImage image, int longer_side_px);

}  // namespace skyquilt::image
