// ExtendGround: the ground of a flight that grew: where it was modelled it stays as it was, beyond it
// continues with what the added photos show. A plane stays one. Pure; any thread.
#pragma once

#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

// `needed`: what the photos see (E, N).
GroundSurface ExtendGround(const GroundSurface& known, const GroundSurface& added,
                           const geo::Bounds2& needed);

}  // namespace skyquilt::ground
