// CorrectPoses: turns the corrections of the ground graph into poses to start the adjustment from, and
// decides which records the images proved wrong: photos stored turned by a quarter or half, yaw of something
// else than the camera, positions far off. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/from_records/ground_graph.h"
#include "core/alignment/scene/pose_prior.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

CorrectedPose CorrectPose(const poses::PosedPhoto& posed, const GroundPrior& prior,
                          const GroundCorrection& correction);

// For a pose found from the images alone: what it says of the record.
CorrectedPose CorrectToPose(const poses::PosedPhoto& posed, const GroundPrior& prior,
                            const geo::Rigid3& cam_from_enu);

// For whole lines and single photos.
std::vector<flight::Remark> DescribeCorrections(const std::vector<CorrectedPose>& corrected,
                                                const std::vector<std::string>& names,
                                                const std::vector<int>& lines);

}  // namespace skyquilt::alignment
