// AverageRotations: one rotation per photo from those of pairs (of their first poses), some of which are
// wrong: from a spanning tree of the best supported, then by least absolute deviations, then by reweighted
// least squares (A. Chatterjee and V. Govindu, ICCV 2013). Pairs that the rest contradicts stand out by their
// residual. Pure; any thread.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

struct AveragedRotations {
  std::vector<Eigen::Quaterniond> cam_from_world;  // by photo
  std::vector<double> residual_rad;                // by pair
};

AveragedRotations AverageRotations(int photos, const std::vector<PhotoPair>& pairs);

}  // namespace skyquilt::alignment
