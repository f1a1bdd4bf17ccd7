// ExtendGround: the ground of a flight that grew: where its finished photos show it, it stays as it was;
// beside them and beyond it continues with what the added photos show. A plane of which these say nothing
// else stays one. Memory: 16 million heights. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

// `needed`: what the added photos see (E, N). `shown`: the outline of what each finished photo shows (E, N).
// Nothing where what is needed lies too far from the known ground for its cells.
std::optional<GroundSurface> ExtendGround(const GroundSurface& known, const GroundSurface& added,
                                          const geo::Bounds2& needed,
                                          const std::vector<std::vector<Eigen::Vector2d>>& shown);

}  // namespace skyquilt::ground
