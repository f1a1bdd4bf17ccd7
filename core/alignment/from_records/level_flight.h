// FindLevelling: whether an adjusted flight hangs tilted because its recorded heights erred by more than its
// recorded camera angles, and how it lies level. Photos of level ground can be tilted together with it
// without any of them disagreeing; only the records say which way is up. A gimbal knows that to a degree, all
// photos alike. A height above take-off is off by tens of metres for the second half of a flight that took
// off again elsewhere, and drifts with the weather. Where all angles of a flight agree that the whole lies
// tilted they are believed, and heights no further than from each photo to the next. Frame `enu`. Pure; any
// thread.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/priors.h"

namespace skyquilt::alignment {

struct Levelling {
  Eigen::Quaterniond level_from_tilted;  // about a horizontal axis
  Eigen::Vector3d pivot_in_enu;          // stays where it is: amid the cameras, which keep their positions
  // By photo: what its recorded height is to be corrected by, to within what the others of its time share.
  std::vector<double> height_correction_m;
  double tilt_rad = 0.0;
  double height_range_m = 0.0;  // between the largest and the smallest correction
};

// Photos in the order of their times, `records` by photo. Nothing where the flight lies as its angles say,
// where these are too few, not a gimbal's, or of two minds, and where the heights are those of a receiver
// that knows centimetres.
std::optional<Levelling> FindLevelling(const BundleProblem& adjusted,
                                       const std::vector<PhotoRecord>& records);

// Poses and points so turned, and with them what was expected of photos placed by images where that is no
// record; recorded heights corrected. What was fitted to the tilted state (the plane) is dropped.
void Level(const Levelling& levelling, const std::vector<PhotoRecord>& records, BundleProblem& problem);

}  // namespace skyquilt::alignment
