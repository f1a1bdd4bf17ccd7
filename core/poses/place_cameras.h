// PlaceCameras: one camera pose per photo from the smoothed chain: the camera in the body, or its own
// recorded rotation where a gimbal held it, turned by the attitude system's error. Frames: `enu`, `body`,
// `cam`. Pure; any thread.
#pragma once

#include <vector>

#include "core/geo/rigid3.h"
#include "core/poses/evidence/smoother_input.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

struct PlacedCamera {
  geo::Rigid3 cam_from_enu;
  Matrix6d covariance = Matrix6d::Zero();  // as in PosedPhoto
  Matrix6d covariance_with_next = Matrix6d::Zero();
  Eigen::Vector3d velocity_in_enu_mps = Eigen::Vector3d::Zero();
  AttitudeOrigin attitude_origin = AttitudeOrigin::kSmoothed;
  double error_radius_m = 0.0;  // 1-sigma horizontal ground error of the image centre
};

// `ground_z_in_enu_m`: the plane for the error radius.
std::vector<PlacedCamera> PlaceCameras(const PreparedSmoothing& prepared, const SmootherOutput& smoothed,
                                       double ground_z_in_enu_m);

}  // namespace skyquilt::poses
