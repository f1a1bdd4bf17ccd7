// Pictures of one channel: as a sensor stored it, 16 bits a pixel, and as numbers. Rows without padding,
// first row on top, as the sensor stored it. Values; any thread.
#pragma once

#include <cstdint>
#include <vector>

namespace skyquilt::image {

struct SampleImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint16_t> samples;  // 8-bit pictures brought to 16 bits
};

struct FloatImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> values;
};

}  // namespace skyquilt::image
