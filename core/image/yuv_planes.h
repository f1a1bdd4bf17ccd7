// FillYuvPlanes: a picture with straight alpha as the planes that video codecs and WebP code: luma of each
// pixel, chroma of each two by two, BT.601 with luma from 16 to 235 (ITU-R BT.601-7; RFC 6386, 9.2), alpha as
// it is. Where some of the four are transparent, chroma is the mean of the others, by their alpha. libwebp's
// own conversion goes over linear light for chroma, which takes four times as long and misses the colours by
// as much once they are coded. Pure; any thread. Cannot fail.
#pragma once

#include <cstdint>

#include "core/image/rgba_image.h"

namespace skyquilt::image {

// Where the planes lie. Chroma has half as many columns and rows, the last of an odd number counted.
struct YuvPlanes {
  std::uint8_t* y = nullptr;
  std::uint8_t* u = nullptr;
  std::uint8_t* v = nullptr;
  std::uint8_t* alpha = nullptr;
  int y_row_bytes = 0;
  int uv_row_bytes = 0;
  int alpha_row_bytes = 0;
};

void FillYuvPlanes(const RgbaImage& straight, const YuvPlanes& planes);

}  // namespace skyquilt::image
