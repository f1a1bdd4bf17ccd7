// Compares a finished map with the simulated world it shows: how far each patch of the map is shifted, in
// pixels.
#pragma once

#include "core/geo/local_frame.h"
#include "core/simulate/world/world.h"
#include "tests/support/memory_sink.h"

namespace skyquilt::test {

struct MapError {
  int patches = 0;
  double shift_rmse_px = 0.0;
  double worst_shift_px = 0.0;
  double mean_east_px = 0.0;
  double mean_south_px = 0.0;
};

// Looks at the fully covered tiles of the finest zoom, in patches of 64 px with enough texture.
MapError MeasureMapError(const MemorySink& map, const simulate::World& world, const geo::LocalFrame& frame);

}  // namespace skyquilt::test
