// CorrectPoses: turns the corrections of the ground graph into poses to start the adjustment from, and
// decides which records the images proved wrong: photos stored turned by a quarter or half, yaw of something
// else than the camera, positions far off. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/from_records/ground_graph.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct CorrectedPose {
  geo::Rigid3 start_cam_from_enu;
  geo::Rigid3 prior_cam_from_enu;  // the record, freed of what was proved wrong
  int quarter_turns = 0;           // counter-clockwise on the ground, 0..3
  bool yaw_was_wrong = false;      // by something else than quarter turns
  bool position_was_wrong = false;
  std::vector<flight::Remark> notes;  // what was corrected, for the user, each going on from the photo's name
  bool yaw_is_course = false;         // no yaw was recorded: the flight's course stood for it
};

CorrectedPose CorrectPose(const poses::PosedPhoto& posed, const GroundPrior& prior,
                          const GroundCorrection& correction);

// How a pose moves a photo over level ground against its record.
GroundCorrection GroundMotion(const poses::PosedPhoto& posed, const GroundPrior& prior,
                              const geo::Rigid3& cam_from_enu);
// For a pose found from the images alone: what it says of the record.
CorrectedPose CorrectToPose(const poses::PosedPhoto& posed, const GroundPrior& prior,
                            const geo::Rigid3& cam_from_enu);

// For whole lines and single photos.
std::vector<flight::Remark> DescribeCorrections(const std::vector<CorrectedPose>& corrected,
                                                const std::vector<std::string>& names,
                                                const std::vector<int>& lines);

}  // namespace skyquilt::alignment
