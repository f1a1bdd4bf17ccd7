// ExtendGround: the ground of a flight that grew: where it was modelled it stays as it was, beyond it
// continues with what the added photos show. A plane stays one. Memory: 16 million heights. Pure; any thread.
#pragma once

#include <optional>

#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

// `needed`: what the photos see (E, N). Nothing where that lies too far from the known ground for its cells.
std::optional<GroundSurface> ExtendGround(const GroundSurface& known, const GroundSurface& added,
                                          const geo::Bounds2& needed);

}  // namespace skyquilt::ground
