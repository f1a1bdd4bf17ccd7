// PlanLawnmower: where each photo of a simulated survey is taken, in enu: parallel lines flown to and fro,
// evenly spaced photos, centred on the origin. Deterministic in the seed. Values; any thread. Angles follow
// core/flight/photo.h: yaw clockwise from true north, pitch 0 = horizon, -90 deg = straight down, roll
// right side down; intrinsic Z-Y-X in NED.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::simulate {

enum class YawRule {
  kAlongCourse,  // the image's top points where the drone flies; turns round from line to line
  kFixed,        // the image's top points along the first line throughout
  kAnywhere,     // every photo turned at random
};

struct TrajectoryOptions {
  int photos = 20;
  double height_m = 60.0;       // above take-off (z = 0)
  double front_overlap = 0.75;  // share of the footprint, along the line
  double side_overlap = 0.65;   // between lines
  double heading_rad = 0.0;     // of the first line, clockwise from north
  double speed_mps = 8.0;
  int photos_per_line = 0;  // 0 = so that the block is about square
  YawRule yaw_rule = YawRule::kAlongCourse;
  double max_tilt_rad = 0.0;       // every photo leans by up to this much, any way (a camera without gimbal)
  double yaw_wander_rad = 0.0;     // 1-sigma of the true yaw about its rule
  double position_jitter_m = 0.0;  // 1-sigma, each horizontal axis, of the true position about the plan
  double height_wander_m = 0.0;    // 1-sigma of a slow wander of the true height
  std::uint32_t seed = 1;

  Result<void> Validate() const;
};

struct TruePose {
  double t_s = 0.0;  // since the first photo
  geo::Rigid3 cam_from_enu;
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  double course_yaw_rad = 0.0;  // what the airframe points at
  int line = 0;
};

struct YawPitchRoll {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

// The rotation of a camera with these gimbal angles, and back (at the exact nadir yaw and roll turn about the
// same axis: roll is then reported as 0).
Eigen::Quaterniond CamFromEnuOfGimbal(const YawPitchRoll& gimbal);
YawPitchRoll GimbalOfCamFromEnu(const Eigen::Quaterniond& cam_from_enu);

Result<std::vector<TruePose>> PlanLawnmower(const TrajectoryOptions& options,
                                            const camera::Intrinsics& intrinsics);

}  // namespace skyquilt::simulate
