// GroundSketch: the ground below all that stands on it (GroundBelow), of which only a sketch is held: of what
// is added the mean of each coarse cell (8 bytes, 36 while Finish looks for the ground in them by
// GroundUnder; four million at most). Heights that lie on the coarse ground stay as fine as they are; those
// that stand on it, or were not measured, are replaced by it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/ground_below.h"

namespace skyquilt::surface {

inline constexpr double kSketchCellM = 0.5;  // of coarse cells, where the heights are finer

class GroundSketch : public GroundBelow {
 public:
  GroundSketch(int columns, int rows, double cell_m);

  void Add(const CellBox& box, const std::vector<float>& heights_m,
           const std::vector<std::uint8_t>& agreeing_photos) override;
  void Finish() override;
  GroundModel GroundOf(const CellBox& box, const std::vector<float>& heights_m,
                       const std::vector<std::uint8_t>& agreeing_photos) const override;

 private:
  std::size_t CoarseCell(int column, int row) const {
    return static_cast<std::size_t>(row / step_) * coarse_columns_ + static_cast<std::size_t>(column / step_);
  }

  int columns_, rows_;
  double cell_m_;
  int step_;  // cells along a coarse one
  int coarse_columns_, coarse_rows_;
  std::vector<float> heights_m_;  // running means until Finish, then of the ground
  std::vector<float> counts_;     // of measured heights; below 0: of filled ones
};

}  // namespace skyquilt::surface
