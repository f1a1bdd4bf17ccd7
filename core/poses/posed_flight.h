// PosedFlight: one pose per photo with its covariance, in one local frame. Value of estimate_poses, input of
// align_flight and, for pose-only maps, of the renderer. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/rolling_shutter.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/local_frame.h"
#include "core/geo/rigid3.h"
#include "core/poses/evidence/assumption.h"
#include "core/poses/pose_report.h"

namespace skyquilt::poses {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

enum class AttitudeOrigin {
  kRecorded,
  kCourse,     // looks down, turned along the course where there is one
  kDirection,  // looks down, turned as a compass says
  kSmoothed
};

struct PosedPhoto {
  flight::Photo photo;
  geo::Rigid3 cam_from_enu;
  // Covariance of the error (rotation about the enu axes in radians, then camera centre in enu metres):
  // true enu_from_cam rotation = Exp(error.head<3>()) * estimated, true centre = estimated + error.tail<3>().
  Matrix6d covariance = Matrix6d::Zero();
  // Cross-covariance with the next photo in time (this row, next column); zero for the last.
  Matrix6d covariance_with_next = Matrix6d::Zero();
  std::optional<Eigen::Vector3d> velocity_in_enu_mps;  // recorded, or by a log
  // Of the clock that all photos on a log have in common: the covariance has it, by the velocity, but photos
  // err by it together.
  double clock_sigma_s = 0.0;
  // While the rows were read, where a finished flight knows it; otherwise speed and gyro say it.
  std::optional<camera::RowMotion> readout_motion;
  double height_above_ground_m = 0.0;
  bool is_beside_dem = false;   // the elevation model that was taken has no height there
  double error_radius_m = 0.0;  // 1-sigma horizontal ground error of the image centre
  AttitudeOrigin attitude_origin = AttitudeOrigin::kRecorded;
  std::string position_source;  // "exif", a list's or a log's file; empty: reckoned, or placed by images
};

struct PosedFlight {
  geo::LocalFrame frame{geo::Wgs84{}};
  double ground_z_in_enu_m = 0.0;  // the flat ground: take-off height
  // The frame's height follows from recorded absolute heights of the cameras and how high above the ground
  // they are taken to be; false: it was given, or nobody knows it.
  bool hangs_on_cameras = false;
  std::vector<PosedPhoto> photos;  // in the order of capture
  std::vector<flight::LeftOutPhoto> left_out;
  // Photos whose records place them nowhere, where asked for: what they show may. Listed in left_out too.
  std::vector<flight::Photo> unplaced;
  std::vector<flight::Remark> warnings;
  std::vector<Assumption> assumptions;  // not among the warnings: what becomes of them, the alignment says
  // The elevation model's height at enu z = 0; nothing without a model that covers the flight.
  std::optional<double> dem_zero_m;
  bool is_placed = true;  // false: the frame's origin is not known, only its scale
  PoseReport report;

  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const PosedPhoto& photo : photos) names.push_back(photo.photo.name);
    return names;
  }
};

}  // namespace skyquilt::poses
