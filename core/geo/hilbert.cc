#include "core/geo/hilbert.h"

#include <utility>

namespace skyquilt::geo {

std::uint64_t HilbertIndex(int order, std::uint32_t x, std::uint32_t y) {
  std::uint64_t index = 0;
  for (int level = order - 1; level >= 0; --level) {
    const std::uint32_t right = (x >> level) & 1u;
    const std::uint32_t lower = (y >> level) & 1u;
    index = (index << 2) | ((3u * right) ^ lower);
    if (lower == 0) {  // the curve turns inside this quadrant
      if (right == 1) {
        const std::uint32_t mask = (level == 31) ? ~0u : ((1u << (level + 1)) - 1u);
        x = ~x & mask;
        y = ~y & mask;
      }
      std::swap(x, y);
    }
  }
  return index;
}

}  // namespace skyquilt::geo
