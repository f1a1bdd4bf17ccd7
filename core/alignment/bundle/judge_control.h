// RefuseControl: what the photos refute of surveyed points before a flight is tied to them: lists whose marks
// are pixels of other pictures, lists that lie where the flight was not, and, among points too few to vote,
// the one that the photos' positions speak against. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/ground_control.h"
#include "core/alignment/scene/photo_set.h"
#include "core/poses/evidence/records_apart.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// Of so many points that most agree on, the others tell by themselves which is wrong.
inline constexpr std::size_t kEnoughToVote = 4;

// How far the recorded positions of the photos in `tied` lie from `centers_in_enu`, where a block has them.
std::optional<poses::RecordsApart> RecordsApartOfBlock(const poses::PosedFlight& posed, const PhotoSet& tied,
                                                       const std::vector<Eigen::Vector3d>& centers_in_enu);

// Points that are refuted leave `problem.control`, and their reports say why. `marks_tied`: by point of
// `control`, of its marks in photos that are tied to others; 0 of a point that has too few of them.
void RefuseControl(const poses::PosedFlight& posed, const std::vector<ControlPoint>& control,
                   const std::vector<std::size_t>& marks_tied, const PhotoSet& tied, BundleProblem& problem,
                   std::vector<ControlReport>& reports);

}  // namespace skyquilt::alignment
