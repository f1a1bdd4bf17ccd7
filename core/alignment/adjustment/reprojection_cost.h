// MakeReprojectionCost: where a photo saw a point against where pose (kPoseSize), point (enu) and lens
// (kLensSize) say it should be, as residuals.h has these numbers, in sigmas. The one cost term that is asked
// tens of thousands of times a solve, so its derivatives are written out. The caller owns what comes back.
#pragma once

#include <Eigen/Core>

#include "core/alignment/adjustment/readout_correction.h"
#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/rigid3.h"

namespace ceres {
class CostFunction;
}

namespace skyquilt::alignment {

ceres::CostFunction* MakeReprojectionCost(const geo::Rigid3& start_cam_from_enu,
                                          const camera::Intrinsics& lens, const Eigen::Vector2d& pixel,
                                          double sigma_px);

// The same of a camera that turns while it reads its rows: the pose is the middle row's, and one more block
// (ReadoutCorrection) corrects `motion`.
ceres::CostFunction* MakeTurningReprojectionCost(const geo::Rigid3& start_cam_from_enu,
                                                 const camera::RowMotion& motion, const ReadoutDoubt& doubt,
                                                 const camera::Intrinsics& lens, const Eigen::Vector2d& pixel,
                                                 double sigma_px);

// The same of a camera that flies on while it reads its rows: one more block (1, seconds) is what its readout
// takes longer than was assumed for `motion`.
ceres::CostFunction* MakeRollingReprojectionCost(const geo::Rigid3& start_cam_from_enu,
                                                 const camera::RowMotion& motion,
                                                 const Eigen::Vector3d& velocity_in_enu_mps,
                                                 const camera::Intrinsics& lens, const Eigen::Vector2d& pixel,
                                                 double sigma_px);

}  // namespace skyquilt::alignment
