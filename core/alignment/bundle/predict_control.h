// PredictControl: how well an adjusted flight knows places that it was not told: each surveyed point is left
// out in turn, the flight adjusted by the others from where it stands, and the point compared with where its
// marks then meet (leave-one-out cross-validation). Nothing is said of fewer than kMinPredictedPoints points,
// nor where that many adjustments would take too long. Metres. One thread; the same result on every machine.
// Memory: one more problem. Errors: none; a point without which the adjustment fails is not told.
#pragma once

#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/ground_control.h"

namespace skyquilt::alignment {

// `problem`: adjusted with control; reports by BundleControl::report.
void PredictControl(const BundleProblem& problem, std::vector<ControlReport>& reports);

}  // namespace skyquilt::alignment
