// GroundBelow: the port by which a writer of heights learns of the ground below what stands on it, part by
// part: every part is added, in the order that it becomes known; then Finish; then each part, cut as may be,
// is asked for. Metres; boxes of cells with their rows one by one, in an order of rows that stays the same;
// a cell is measured where photos agree on it (not 0), and tells less where not. NaN where there is no
// height, which stays so. Add and Finish from one thread, GroundOf from any. No errors.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/dense_surface.h"

namespace skyquilt::surface {

struct GroundModel {
  std::vector<float> heights_m;
  std::vector<std::uint8_t> is_ground;  // measured, and of the ground; 0 where bridged
};

class GroundBelow {
 public:
  virtual ~GroundBelow() = default;

  virtual void Add(const CellBox& box, const std::vector<float>& heights_m,
                   const std::vector<std::uint8_t>& agreeing_photos) = 0;
  virtual void Finish() = 0;
  // Of the same cells as were added.
  virtual GroundModel GroundOf(const CellBox& box, const std::vector<float>& heights_m,
                               const std::vector<std::uint8_t>& agreeing_photos) const = 0;
};

}  // namespace skyquilt::surface
