// ShiftBetween: how far the heights of one flight lie off those of another of the same ground, sideways and
// up, so that what is left between them is what has changed. Flights whose positions come from satellites
// alone lie metres apart; most of the ground is taken to have stayed as it was. Sideways it is tried cell by
// cell up to kMaxSidewaysM, then between cells, and believed only where the heights then agree clearly
// better: level ground cannot tell. Up it is the median. Two grids of the same cells, rows from the north,
// NaN where nothing is known or was measured; metres. Pure; any thread. Absent: too little is known in both.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace skyquilt::surface {

struct HeightGrid {
  int columns = 0, rows = 0;
  double cell_m = 1.0;
  std::span<const float> heights_m;
};

// What `then` shows at a place p, `now` shows at p + east_north_m, up_m higher.
struct HeightShift {
  Eigen::Vector2d east_north_m = Eigen::Vector2d::Zero();
  double up_m = 0.0;
  // By how much patches of ground that stayed as it was still differ, one standard deviation: what a level
  // anywhere is unsure by. Absent: too few patches.
  std::optional<double> sigma_m;
};

inline constexpr double kMaxSidewaysM = 6.0;
inline constexpr int kMinComparedCells = 400;

std::optional<HeightShift> ShiftBetween(const HeightGrid& now, const HeightGrid& then);

}  // namespace skyquilt::surface
