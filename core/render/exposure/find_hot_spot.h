// FindHotSpot: in which direction ground looks brighter than the smooth light of the flight explains, which
// is opposite the sun: shadows hide behind what throws them. By what the photos show, since clocks are seldom
// sure of their zone. One thread; the time does not grow with the samples but for one pass.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/render/exposure/exposure_samples.h"

namespace skyquilt::render {

// misfits[i]: of samples[i], by MisfitsOf. None where nothing stands out of the noise.
std::optional<Eigen::Vector2d> FindHotSpot(const std::vector<ExposureSample>& samples,
                                           const std::vector<double>& misfits, double widest_look);

}  // namespace skyquilt::render
