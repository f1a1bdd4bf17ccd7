// The hot spot of a flight's light: FindHotSpot tells in which direction ground looks brighter than the
// smooth light explains, which is opposite the sun (shadows hide behind what throws them), by what the photos
// show, since clocks are seldom sure of their zone. SettleHotSpot says how much of it is taken out of the
// photos: as high as the overlaps show it, at each of its widths (kSpotReaches), for as much as they are sure
// of it, and nothing of what does not foretell photos that had no part in it. One thread; finding takes one
// pass over the samples, settling O(samples x terms).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/render/exposure/exposure_samples.h"
#include "core/render/exposure/light_equations.h"

namespace skyquilt::render {

// misfits[i]: of samples[i], by MisfitsOf. None where nothing stands out of the noise.
std::optional<Eigen::Vector2d> FindHotSpot(const std::vector<ExposureSample>& samples,
                                           const std::vector<double>& misfits, double widest_look);

// Where the hot spots of a flight's photos lie, in enu, and how far around each the ground is of its kind.
struct SpotsOnGround {
  std::vector<Eigen::Vector2d> middles_m;  // by photo
  double reach_m = 0.0;
};

// `light` is SolveLight's of the same samples, channel and terms, which have a hot spot. Its hills are made
// as high as settled (all 0: taken back) and the rest fits the samples with them so. Returned by photo: the
// share of that which it shows, 0 to 2: grass has more of a hot spot than bare soil, so that it is told by
// what all photos show of the ground around the point opposite the sun (`spots`), not by one of them, which
// may see but the flank of its own; 1 where grounds do not differ by more than chance, or none tells.
std::vector<double> SettleHotSpot(const std::vector<ExposureSample>& samples, std::size_t channel,
                                  const LightTerms& terms, const SpotsOnGround& spots, SolvedLight& light);

}  // namespace skyquilt::render
