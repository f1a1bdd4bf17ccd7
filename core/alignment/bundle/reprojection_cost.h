// MakeReprojectionCost: where a photo saw a point against where pose (kPoseSize), point (enu) and lens
// (kLensSize) say it should be, as residuals.h has these numbers, in sigmas. The one cost term that is asked
// tens of thousands of times a solve, so its derivatives are written out; and there are millions of them, so
// what all of one photo have in common is kept once. The caller owns what comes back.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/alignment/bundle/readout_correction.h"
#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/rigid3.h"

namespace ceres {
class CostFunction;
}

namespace skyquilt::alignment {

// Where a photo was taken and with which lens, before the solve changes either. Of a camera that flies on
// while it reads its rows it is the middle row's.
struct CameraStart {
  Eigen::Matrix3d cam_from_enu;
  Eigen::Vector3d center_in_enu;
  Eigen::Vector3d shift_in_enu_m;  // from the first row to the last
  camera::Intrinsics lens;
};

// `motion` without turns: a camera that also turns has another start at every row.
std::shared_ptr<const CameraStart> StartOf(const geo::Rigid3& cam_from_enu, const camera::RowMotion& motion,
                                           const camera::Intrinsics& lens);

ceres::CostFunction* MakeReprojectionCost(std::shared_ptr<const CameraStart> start,
                                          const Eigen::Vector2d& pixel, double sigma_px);

// The same of a camera that turns while it reads its rows: the pose is the middle row's, and one more block
// (ReadoutCorrection) corrects `motion`.
ceres::CostFunction* MakeTurningReprojectionCost(const geo::Rigid3& start_cam_from_enu,
                                                 const camera::RowMotion& motion, const ReadoutDoubt& doubt,
                                                 const camera::Intrinsics& lens, const Eigen::Vector2d& pixel,
                                                 double sigma_px);

// The same of a camera that flies on while it reads its rows: one more block (1, seconds) is what its readout
// takes longer than was assumed for the start.
ceres::CostFunction* MakeRollingReprojectionCost(std::shared_ptr<const CameraStart> start,
                                                 const Eigen::Vector3d& velocity_in_enu_mps,
                                                 const Eigen::Vector2d& pixel, double sigma_px);

}  // namespace skyquilt::alignment
