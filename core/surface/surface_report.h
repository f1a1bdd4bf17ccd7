// What came of matching heights. Values; any thread.
#pragma once

#include <optional>

namespace skyquilt::surface {

struct SurfaceReport {
  double cell_m = 0.0;
  // Of the cells that a photo shows: those whose height several photos agree on; the others were filled from
  // around.
  double measured_share = 0.0;
  std::optional<double> contour_interval_m = {};  // of the ground, where that was written
};

}  // namespace skyquilt::surface
