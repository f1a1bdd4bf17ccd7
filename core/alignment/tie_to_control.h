// TieToControl: turns ground control points into observations of the adjustment and moves the block to them,
// so that the adjustment starts near. ReportControl says how well each fits afterwards. Heights count
// relative to each other: survey and drone seldom share their zero. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/bundle_adjustment.h"
#include "core/alignment/ground_control.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// `problem` has been adjusted without control. A point needs two sightings in photos that are tied to others.
// One that lies far off where the others put the block is not used, and its report says so.
void TieToControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                  BundleProblem& problem, std::vector<ControlReport>& reports);

void ReportControl(const BundleProblem& problem, std::vector<ControlReport>& reports);

}  // namespace skyquilt::alignment
