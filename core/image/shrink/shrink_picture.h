// A picture in fewer pixels, each the mean of the area that it covers. Pure; the same bytes on any processor;
// any thread. Cannot fail.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/image/rgba_image.h"

namespace skyquilt::image {

// Rows of 8-bit channels, pixel by pixel.
struct ChannelRows {
  const std::uint8_t* first = nullptr;
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  std::size_t row_bytes = 0;
};

// A picture without alpha, as OpenCV's INTER_AREA makes it, in a third of its time where the sides are no
// whole multiples: rows are added up by vector instructions before columns. Into to_width_px * to_height_px *
// channels bytes without gaps; both sides are at least 1 and no longer than the picture's.
void ShrinkByArea(const ChannelRows& picture, int to_width_px, int to_height_px, std::uint8_t* to);

// A picture with straight alpha, by which pixels are weighted too, so that what is transparent colours
// nothing. Its longer side becomes `longer_side_px` (at least 1), the other in proportion and at least one
// pixel. One that is no larger stays as it is.
RgbaImage ShrinkPicture(RgbaImage image, int longer_side_px);

}  // namespace skyquilt::image
