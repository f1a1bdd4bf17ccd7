// ScaleSpace: a grey image blurred more and more, and the spots that stand out from it at their own size (D.
// Lowe, Distinctive image features from scale-invariant keypoints, IJCV 2004). The image is taken as it is,
// not doubled: who wants finer spots hands in more pixels. Blurred to 16 bits of weights; beyond the edge the
// last pixels go on. Values; any thread; the same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/pixel_bytes.h"

namespace skyquilt::alignment {

// A grey image in finer steps than bytes: rows without padding, in 128ths of a grey level, below 2^15.
// Sides are of one pixel or more.
struct BlurredImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint16_t, PixelAllocator<std::uint16_t>> values;

  const std::uint16_t* Row(int y) const { return values.data() + static_cast<std::size_t>(y) * width_px; }
  std::uint16_t* Row(int y) { return values.data() + static_cast<std::size_t>(y) * width_px; }
};

inline constexpr int kLayersAnOctave = 3;
inline constexpr float kFirstBlurPx = 1.6F;  // of an octave's first layer, in the octave's pixels

struct Octave {
  int step_px = 1;  // pixels of the image to one of the octave, which lies on each first of them
  std::vector<BlurredImage> layers;  // kLayersAnOctave + 3
};

// Of octaves so large that a feature has room, the finest first.
std::vector<Octave> BuildScaleSpace(int width_px, int height_px, const std::uint8_t* grey);

// A spot brighter or darker than all around it, in its octave's pixels.
struct ScalePoint {
  int octave = 0;
  int layer = 0;  // nearest
  float x_px = 0.0F;
  float y_px = 0.0F;
  float blur_px = 0.0F;   // at which it stands out most
  float contrast = 0.0F;  // grey levels
};

// Spots of at least this contrast that are no mere edges, by octave, layer, row and column.
std::vector<ScalePoint> FindScalePoints(const std::vector<Octave>& octaves, float min_contrast);

}  // namespace skyquilt::alignment
