// SampleDem: an elevation model brought into a flight's enu frame as a regular grid of heights. Holes take
// the mean of what lies around them. Frame enu, metres. Reads the model on the calling thread; otherwise
// pure.
#pragma once

#include <optional>

#include "core/geo/bounds.h"
#include "core/geo/dem_source.h"
#include "core/geo/local_frame.h"
#include "core/ground/membrane_grid.h"

namespace skyquilt::ground {

struct ElevationModel {
  const geo::DemSource* source = nullptr;
  double zero_m = 0.0;  // its height at z = 0 of the flight's frame
};

// Nothing where the model covers less than half of the area. Cells grow beyond cell_m where there would be
// too many.
std::optional<MembraneGrid> SampleDem(const ElevationModel& model, const geo::LocalFrame& frame,
                                      const geo::Bounds2& area_in_enu, double cell_m);

}  // namespace skyquilt::ground
