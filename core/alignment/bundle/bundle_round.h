// SolveRound: one solve of a bundle adjustment from the problem's present state, which becomes the solution
// where Ceres finds a usable one; between rounds AdjustBundle drops outliers. line_bias: in and out, radians,
// in cam. Not for concurrent use of one problem.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"

namespace skyquilt::alignment {

void SolveRound(const BundleOptions& options, BundleProblem& problem, std::vector<Eigen::Vector3d>& line_bias,
                BundleSummary& summary);

}  // namespace skyquilt::alignment
