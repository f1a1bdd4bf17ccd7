// What was recorded of where a photo was taken from and how it was turned, as it is and freed of what the
// images proved wrong. Frame `enu` of the flight. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct PhotoRecord {
  std::optional<Eigen::Vector3d> center_in_enu;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Constant(3.0);
  std::optional<Eigen::Quaterniond> cam_from_enu;  // the recorded attitude
  double sigma_tilt_rad = 0.05;                    // of it
  std::optional<double> height_above_ground_m;
  bool is_unplaced = false;  // nothing recorded places it: its pose in the flight stands for none
};

// What comparing a photo with the others showed, of its record and of its picture.
struct PhotoFindings {
  geo::Rigid3 start_cam_from_enu;
  geo::Rigid3 prior_cam_from_enu;  // the record, freed of what was proved wrong
  int quarter_turns = 0;           // counter-clockwise on the ground, 0..3
  bool yaw_was_wrong = false;      // by something else than quarter turns
  bool position_was_wrong = false;
  std::vector<flight::Remark> notes;  // what was corrected, for the user, each going on from the photo's name
  bool yaw_is_course = false;         // no yaw was recorded: the flight's course stood for it
  std::optional<int> copy_of;         // an earlier photo with the same picture
  // The fine detail that it shows, as a share of what others show of the same ground; nothing where too few
  // others do.
  std::optional<double> sharpness;
  bool is_blurred = false;         // far less sharp than others of the same ground
  bool shows_other_place = false;  // rich in detail, yet nothing in common with photos that overlap and agree
};

// A lens as recorded and as adjusted, and how far the record holds it. A value; any thread.
struct BundleLens {
  camera::Intrinsics recorded;    // the prior
  camera::Intrinsics intrinsics;  // in: start; out: adjusted
  double sigma_focal_share = 0.01;
  double sigma_center_px = 10.0;
  double sigma_k = 0.05;  // of k1 and of k2
  double sigma_p = 0.001;
  bool is_fixed = false;
  // The time from the first row of a picture to the last is an unknown of the adjustment: of photos that have
  // a velocity and no doubts, whose motion it becomes.
  bool finds_readout = false;
  double readout_s = 0.0;             // in: start; out: adjusted
  double found_sigma_focal_px = 0.0;  // out: what the images left of the prior
};

}  // namespace skyquilt::alignment
