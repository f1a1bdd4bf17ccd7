// The cost terms of the bundle adjustment, each in units of its own sigma. Poses are six numbers from a fixed
// start: turn (radians, in cam: cam = Exp(turn) * start) and shift of the centre (enu metres). Lens: focal as
// a factor, centre in pixels, k1 k2, p1 p2. Priors are written for automatic differentiation; the derivatives
// of reprojection, which is asked tens of thousands of times a solve, are written out.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/alignment/bundle/readout_motion.h"
#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/rigid3.h"

namespace ceres {
class CostFunction;
}

namespace skyquilt::alignment {

inline constexpr int kPoseSize = 6;
inline constexpr int kLensSize = 7;  // log focal factor, cx, cy, k1, k2, p1, p2

// What was recorded of three of a pose's numbers, from kFirst on, apart from an error that several share.
template <int kFirst>
struct RecordResidual {
  Eigen::Vector3d start_from_prior;
  Eigen::Vector3d sigma;

  template <typename T>
  bool operator()(const T* pose, const T* bias, T* residual) const {
    for (int k = 0; k < 3; ++k) residual[k] = (pose[kFirst + k] + start_from_prior[k] - bias[k]) / sigma[k];
    return true;
  }
};
// The flight line shares its error (in cam); Log(start * prior^-1), small.
using AttitudeResidual = RecordResidual<0>;
// The whole flight shares its error.
using PositionResidual = RecordResidual<3>;

// The same of a photo that was looked up by its time on a track: its clock's error is shared as well.
struct TimedPositionResidual {
  PositionResidual position;
  Eigen::Vector3d by_clock_mps;

  template <typename T>
  bool operator()(const T* pose, const T* bias, const T* clock_error_s, T* residual) const {
    position(pose, bias, residual);
    for (int k = 0; k < 3; ++k) residual[k] -= clock_error_s[0] * by_clock_mps[k] / position.sigma[k];
    return true;
  }
};

template <int kSize>
struct PriorResidual {
  Eigen::Matrix<double, kSize, 1> expected;
  Eigen::Matrix<double, kSize, 1> sigma;

  template <typename T>
  bool operator()(const T* value, T* residual) const {
    for (int k = 0; k < kSize; ++k) residual[k] = (value[k] - expected[k]) / sigma[k];
    return true;
  }
};

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

// Where a photo saw a point against where pose (kPoseSize), point (enu) and lens (kLensSize) say it should
// be. There are millions of them, so what all of one photo have in common is kept once. The caller owns what
// comes back.
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
