#include "core/image/rgba_image.h"

#include <algorithm>
#include <cstring>

namespace skyquilt::image {

void StraightenAlpha(const std::uint8_t* premultiplied, int count, std::uint8_t* straight) {
  for (int i = 0; i < count; ++i, premultiplied += 4, straight += 4) {
    const int alpha = premultiplied[3];
    std::memcpy(straight, premultiplied, 4);
    if (alpha == 255 || alpha == 0) continue;
    for (int c = 0; c < 3; ++c)
      straight[c] = static_cast<std::uint8_t>(std::min(255, (premultiplied[c] * 255 + alpha / 2) / alpha));
  }
}

}  // namespace skyquilt::image
