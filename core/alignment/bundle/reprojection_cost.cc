#include "core/alignment/bundle/reprojection_cost.h"

#include <ceres/sized_cost_function.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "core/poses/so3.h"

namespace skyquilt::alignment {
namespace {

constexpr double kMinDepthM = 1e-3;

// Exp(turn), and how it changes: Exp(turn + d) = Exp(change * d) * Exp(turn) for small d (the left Jacobian
// of the rotations).
struct Turn {
  Eigen::Matrix3d rotation, change;

  explicit Turn(const Eigen::Vector3d& turn) {
    const double angle2 = turn.squaredNorm(), angle = std::sqrt(angle2);
    // sin(a) / a, (1 - cos(a)) / a^2, (a - sin(a)) / a^3, by their series where the quotients lose digits.
    const bool is_small = angle < 1e-3;
    const double first = is_small ? 1.0 - angle2 / 6.0 : std::sin(angle) / angle;
    const double half_sine = std::sin(0.5 * angle);
    const double second = is_small ? 0.5 - angle2 / 24.0 : 2.0 * half_sine * half_sine / angle2;
    const double third = is_small ? 1.0 / 6.0 - angle2 / 120.0 : (angle - std::sin(angle)) / (angle2 * angle);
    const Eigen::Matrix3d cross = poses::Skew(turn), cross2 = cross * cross;
    rotation = Eigen::Matrix3d::Identity() + first * cross + second * cross2;
    change = Eigen::Matrix3d::Identity() + second * cross + third * cross2;
  }
};

class ReprojectionCost final : public ceres::SizedCostFunction<2, kPoseSize, 3, kLensSize> {
 public:
  ReprojectionCost(std::shared_ptr<const CameraStart> start, const Eigen::Vector2d& pixel, double sigma_px)
      : start_(std::move(start)), pixel_(pixel), sigma_px_(sigma_px) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const double* pose = parameters[0];
    const double* lens = parameters[2];
    const CameraStart& start = *start_;
    const Turn turn(Eigen::Vector3d(pose[0], pose[1], pose[2]));
    const Eigen::Vector3d center_in_enu =
        start.center_in_enu + RowShare() * start.shift_in_enu_m + Eigen::Vector3d(pose[3], pose[4], pose[5]);
    const Eigen::Matrix3d cam_from_enu = turn.rotation * start.cam_from_enu;
    const Eigen::Vector3d in_cam =
        cam_from_enu * (Eigen::Map<const Eigen::Vector3d>(parameters[1]) - center_in_enu);
    if (in_cam.z() < kMinDepthM) return false;
    const double x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z();
    const double k1 = lens[3], k2 = lens[4], p1 = lens[5], p2 = lens[6];
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * start.lens.k3));
    const Eigen::Vector2d bent(x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                               y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
    const Eigen::Vector2d focal = std::exp(lens[0]) * Eigen::Vector2d(start.lens.focal_x_px / sigma_px_,
                                                                      start.lens.focal_y_px / sigma_px_);
    const Eigen::Vector2d center_less_pixel_px(start.lens.center_x_px - pixel_.x(),
                                               start.lens.center_y_px - pixel_.y());
    const Eigen::Vector2d shift(lens[1], lens[2]);
    Eigen::Map<Eigen::Vector2d>{residuals} =
        focal.cwiseProduct(bent) + (center_less_pixel_px + shift) / sigma_px_;
    if (jacobians == nullptr) return true;

    const double steeper = k1 + r2 * (2.0 * k2 + 3.0 * r2 * start.lens.k3);  // of `radial` by r2
    const double both = 2.0 * (x * y * steeper + p1 * x + p2 * y);
    Eigen::Matrix2d bent_by_flat;
    bent_by_flat << radial + 2.0 * x * x * steeper + 2.0 * p1 * y + 6.0 * p2 * x, both, both,
        radial + 2.0 * y * y * steeper + 6.0 * p1 * y + 2.0 * p2 * x;
    Eigen::Matrix<double, 2, 3> flat_by_cam;
    flat_by_cam << 1.0, 0.0, -x, 0.0, 1.0, -y;
    const Eigen::Matrix<double, 2, 3> by_cam = focal.asDiagonal() * bent_by_flat * flat_by_cam / in_cam.z();
    const Eigen::Matrix<double, 2, 3> by_point = by_cam * cam_from_enu;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>> by_pose(jacobians[0]);
      by_pose.leftCols<3>() = -by_cam * poses::Skew(in_cam) * turn.change;
      by_pose.rightCols<3>() = -by_point;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[1]} = by_point;
    }
    if (jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kLensSize, Eigen::RowMajor>> by_lens(jacobians[2]);
      by_lens.col(0) = focal.cwiseProduct(bent);
      by_lens.block<2, 2>(0, 1) = Eigen::Matrix2d::Identity() / sigma_px_;
      by_lens.col(3) = r2 * focal.cwiseProduct(Eigen::Vector2d(x, y));
      by_lens.col(4) = r2 * by_lens.col(3);
      by_lens.col(5) = focal.cwiseProduct(Eigen::Vector2d(2.0 * x * y, r2 + 2.0 * y * y));
      by_lens.col(6) = focal.cwiseProduct(Eigen::Vector2d(r2 + 2.0 * x * x, 2.0 * x * y));
    }
    return true;
  }

  double RowShare() const { return camera::RowShare(pixel_.y(), start_->lens.height_px); }

 private:
  const std::shared_ptr<const CameraStart> start_;
  const Eigen::Vector2d pixel_;
  const double sigma_px_;
};

class TurningReprojectionCost final
    : public ceres::SizedCostFunction<2, kPoseSize, 3, kLensSize, kCorrectionSize> {
 public:
  TurningReprojectionCost(const geo::Rigid3& start, const camera::RowMotion& motion,
                          const ReadoutDoubt& doubt, const camera::Intrinsics& lens,
                          const Eigen::Vector2d& pixel, double sigma_px)
      : share_(camera::RowShare(pixel.y(), lens.height_px)),
        turn_by_correction_(TurnByCorrection(motion, doubt, share_)),
        row_from_middle_(motion.TurnAt(share_).toRotationMatrix()),
        start_rotation_(start.rotation.toRotationMatrix()),
        start_center_in_enu_(start.TargetOriginInSource() + share_ * motion.shift_in_enu_m),
        of_row_(StartOf(geo::Rigid3{}, {}, lens), pixel, sigma_px) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const double* pose = parameters[0];
    const Eigen::Map<const ReadoutCorrection> off(parameters[3]);
    const Turn turn(Eigen::Vector3d(pose[0], pose[1], pose[2]));
    const Turn off_turn(turn_by_correction_ * off);
    const Eigen::Vector3d center_in_enu =
        start_center_in_enu_ + Eigen::Vector3d(pose[3], pose[4], pose[5]) + share_ * off.segment<3>(3);
    const Eigen::Matrix3d middle_from_enu = turn.rotation * start_rotation_;
    const Eigen::Vector3d in_middle =
        middle_from_enu * (Eigen::Map<const Eigen::Vector3d>(parameters[1]) - center_in_enu);
    const Eigen::Vector3d in_off = off_turn.rotation * in_middle;
    const Eigen::Vector3d in_row = row_from_middle_ * in_off;
    // Within the row's own axes it is a camera that stands still.
    const double still[kPoseSize] = {};
    const double* row_parameters[] = {still, in_row.data(), parameters[2]};
    if (jacobians == nullptr) return of_row_.Evaluate(row_parameters, residuals, nullptr);
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_row;
    double* row_jacobians[] = {nullptr, by_row.data(), jacobians[2]};
    if (!of_row_.Evaluate(row_parameters, residuals, row_jacobians)) return false;
    const Eigen::Matrix<double, 2, 3> by_off = by_row * row_from_middle_;
    const Eigen::Matrix<double, 2, 3> by_middle = by_off * off_turn.rotation;
    const Eigen::Matrix<double, 2, 3> by_point = by_middle * middle_from_enu;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>> by_pose(jacobians[0]);
      by_pose.leftCols<3>() = -by_middle * poses::Skew(in_middle) * turn.change;
      by_pose.rightCols<3>() = -by_point;
    }
    if (jacobians[1] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>{jacobians[1]} = by_point;
    }
    if (jacobians[3] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kCorrectionSize, Eigen::RowMajor>> by_correction(jacobians[3]);
      by_correction = -by_off * poses::Skew(in_off) * off_turn.change * turn_by_correction_;
      by_correction.middleCols<3>(3) = -share_ * by_point;
    }
    return true;
  }

 private:
  const double share_;
  const Eigen::Matrix<double, 3, kCorrectionSize> turn_by_correction_;
  const Eigen::Matrix3d row_from_middle_, start_rotation_;  // the latter cam_from_enu of the middle row
  const Eigen::Vector3d start_center_in_enu_;
  const ReprojectionCost of_row_;
};

class RollingReprojectionCost final : public ceres::SizedCostFunction<2, kPoseSize, 3, kLensSize, 1> {
 public:
  RollingReprojectionCost(std::shared_ptr<const CameraStart> start,
                          const Eigen::Vector3d& velocity_in_enu_mps, const Eigen::Vector2d& pixel,
                          double sigma_px)
      : of_row_(std::move(start), pixel, sigma_px),
        center_by_readout_(of_row_.RowShare() * velocity_in_enu_mps) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Matrix<double, kPoseSize, 1> pose =
        Eigen::Map<const Eigen::Matrix<double, kPoseSize, 1>>(parameters[0]);
    pose.tail<3>() += parameters[3][0] * center_by_readout_;
    const double* row_parameters[] = {pose.data(), parameters[1], parameters[2]};
    if (jacobians == nullptr) return of_row_.Evaluate(row_parameters, residuals, nullptr);
    Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor> by_pose;
    double* row_jacobians[] = {by_pose.data(), jacobians[1], jacobians[2]};
    if (!of_row_.Evaluate(row_parameters, residuals, row_jacobians)) return false;
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor>>{jacobians[0]} = by_pose;
    }
    if (jacobians[3] != nullptr) {
      Eigen::Map<Eigen::Vector2d>{jacobians[3]} = by_pose.rightCols<3>() * center_by_readout_;
    }
    return true;
  }

 private:
  const ReprojectionCost of_row_;
  const Eigen::Vector3d center_by_readout_;
};

}  // namespace

std::shared_ptr<const CameraStart> StartOf(const geo::Rigid3& cam_from_enu, const camera::RowMotion& motion,
                                           const camera::Intrinsics& lens) {
  return std::make_shared<const CameraStart>(CameraStart{cam_from_enu.rotation.toRotationMatrix(),
                                                         cam_from_enu.TargetOriginInSource(),
                                                         motion.shift_in_enu_m, lens});
}

ceres::CostFunction* MakeRollingReprojectionCost(std::shared_ptr<const CameraStart> start,
                                                 const Eigen::Vector3d& velocity_in_enu_mps,
                                                 const Eigen::Vector2d& pixel, double sigma_px) {
  return new RollingReprojectionCost(std::move(start), velocity_in_enu_mps, pixel, sigma_px);
}

ceres::CostFunction* MakeTurningReprojectionCost(const geo::Rigid3& start_cam_from_enu,
                                                 const camera::RowMotion& motion, const ReadoutDoubt& doubt,
                                                 const camera::Intrinsics& lens, const Eigen::Vector2d& pixel,
                                                 double sigma_px) {
  return new TurningReprojectionCost(start_cam_from_enu, motion, doubt, lens, pixel, sigma_px);
}

ceres::CostFunction* MakeReprojectionCost(std::shared_ptr<const CameraStart> start,
                                          const Eigen::Vector2d& pixel, double sigma_px) {
  return new ReprojectionCost(std::move(start), pixel, sigma_px);
}

}  // namespace skyquilt::alignment
