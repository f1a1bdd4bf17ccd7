#include "tests/bench/poses/pose_metrics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/camera/footprint.h"
#include "core/geo/lat_lon.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::bench {
namespace {

using Eigen::Matrix2d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

const camera::Intrinsics& Camera() {
  static const camera::Intrinsics camera = camera::Intrinsics::Centered(5472, 3648, 3650.0);
  return camera;
}

geo::Rigid3 CamFromEnu(const Quaterniond& enu_from_body, const Vector3d& position) {
  const Quaterniond cam_from_enu = poses::CamFromBody() * enu_from_body.conjugate();
  return geo::Rigid3::FromRotationAndTargetOrigin(cam_from_enu, position);
}

geo::Rigid3 Shifted(const poses::SmoothedPose& pose, int axis, double step) {
  if (axis < 3) {
    return CamFromEnu(geo::RotationFromVector(step * Vector3d::Unit(axis)) * pose.enu_from_body,
                      pose.position_in_enu_m);
  }
  return CamFromEnu(pose.enu_from_body, pose.position_in_enu_m + step * Vector3d::Unit(axis - 3));
}

std::optional<Vector2d> Carry(const geo::Rigid3& from, const geo::Rigid3& to, const Vector2d& pixel) {
  const std::optional<Vector3d> ground = camera::GroundFromPixel(Camera(), from, pixel, 0.0);
  if (!ground) return std::nullopt;
  const Vector3d in_cam = to * *ground;
  if (in_cam.z() < 0.1) return std::nullopt;
  return Camera().Project(in_cam);
}

// A pixel of photo i carried to photo j with both poses uncertain: its mean and covariance by the unscented
// transform, since a tilt of ten degrees bends the way of a pixel far beyond its slope.
struct CarriedPixel {
  Vector2d mean = Vector2d::Zero();
  Matrix2d covariance = Matrix2d::Zero();
};

poses::SmoothedPose Moved(const poses::SmoothedPose& pose, const Eigen::Matrix<double, 6, 1>& by) {
  poses::SmoothedPose moved = pose;
  moved.enu_from_body = geo::RotationFromVector(by.head<3>()) * pose.enu_from_body;
  moved.position_in_enu_m += by.tail<3>();
  return moved;
}

std::optional<CarriedPixel> CarryUncertain(const poses::SmoothedPose& i, const poses::SmoothedPose& j,
                                           const Vector2d& pixel) {
  using Vector12d = Eigen::Matrix<double, 12, 1>;
  Eigen::Matrix<double, 12, 12> joint;
  joint << i.covariance, i.covariance_with_next, i.covariance_with_next.transpose(), j.covariance;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> axes(joint);
  const auto carry = [&](const Vector12d& by) {
    const poses::SmoothedPose a = Moved(i, by.head<6>());
    const poses::SmoothedPose b = Moved(j, by.tail<6>());
    return Carry(CamFromEnu(a.enu_from_body, a.position_in_enu_m),
                 CamFromEnu(b.enu_from_body, b.position_in_enu_m), pixel);
  };
  // Symmetric points at sqrt(3) sigma with the weights that keep a Gaussian's fourth moments.
  constexpr double kSpread = 3.0;
  const auto middle = carry(Vector12d::Zero());
  if (!middle) return std::nullopt;
  std::vector<Vector2d> points;
  for (int axis = 0; axis < 12; ++axis) {
    const double sigma = std::sqrt(std::max(0.0, axes.eigenvalues()(axis)));
    for (const double sign : {-1.0, 1.0}) {
      const auto point = carry(sign * std::sqrt(kSpread) * sigma * axes.eigenvectors().col(axis));
      if (!point) return std::nullopt;
      points.push_back(*point);
    }
  }
  const double weight = 1.0 / (2.0 * kSpread);
  CarriedPixel carried;
  carried.mean = (1.0 - 12.0 / kSpread) * *middle;
  for (const Vector2d& point : points) carried.mean += weight * point;
  // About the middle point: the negative middle weight then cannot make it lose its sign.
  for (const Vector2d& point : points) {
    carried.covariance += weight * (point - carried.mean) * (point - carried.mean).transpose();
  }
  carried.covariance += 0.25 * Matrix2d::Identity();
  return carried;
}

struct Sums {
  double position = 0, height = 0, tilt = 0, yaw = 0, center = 0, corner = 0, nees_p = 0, nees_r = 0,
         worst = 0;
  double next = 0, window = 0, search = 0;
  int pairs = 0;
  int photos = 0, carried = 0, covered = 0, centers = 0;
};

void AddPhoto(const FlightTruth& truth, const poses::SmoothedPose& pose, Sums& sums) {
  const Vector3d dp = truth.position - pose.position_in_enu_m;
  const Vector3d dr = geo::VectorFromRotation(truth.enu_from_body * pose.enu_from_body.conjugate());
  sums.position += dp.head<2>().squaredNorm();
  sums.height += dp.z() * dp.z();
  const Vector3d down = truth.enu_from_body * pose.enu_from_body.conjugate() * Vector3d::UnitZ();
  sums.tilt += std::pow(std::atan2(down.head<2>().norm(), down.z()), 2);
  sums.yaw += dr.z() * dr.z();
  sums.nees_p += dp.dot(pose.covariance.bottomRightCorner<3, 3>().ldlt().solve(dp)) / 3.0;
  sums.nees_r += dr.dot(pose.covariance.topLeftCorner<3, 3>().ldlt().solve(dr)) / 3.0;
  sums.worst = std::max(sums.worst, dp.norm());
  const geo::Rigid3 cam = CamFromEnu(pose.enu_from_body, pose.position_in_enu_m);
  const geo::Rigid3 true_cam = CamFromEnu(truth.enu_from_body, truth.position);
  const auto ground_error = [&](const Vector2d& pixel) {
    const auto a = camera::GroundFromPixel(Camera(), cam, pixel, 0.0);
    const auto b = camera::GroundFromPixel(Camera(), true_cam, pixel, 0.0);
    return a && b ? (*a - *b).head<2>().squaredNorm() : dp.squaredNorm();
  };
  sums.center += ground_error({Camera().center_x_px, Camera().center_y_px});
  sums.corner += ground_error({0.0, 0.0});
  ++sums.photos;
}

// Where the photo's axis meets the ground, by its pose's small errors.
Eigen::Matrix<double, 2, 6> CenterByPose(const poses::SmoothedPose& pose) {
  Eigen::Matrix<double, 2, 6> by_pose = Eigen::Matrix<double, 2, 6>::Zero();
  const Vector2d center(Camera().center_x_px, Camera().center_y_px);
  for (int axis = 0; axis < 6; ++axis) {
    const double step = axis < 3 ? 1e-5 : 1e-3;
    const auto plus = camera::GroundFromPixel(Camera(), Shifted(pose, axis, step), center, 0.0);
    const auto minus = camera::GroundFromPixel(Camera(), Shifted(pose, axis, -step), center, 0.0);
    if (plus && minus) by_pose.col(axis) = (*plus - *minus).head<2>() / (2.0 * step);
  }
  return by_pose;
}

// How far the two image centres lie wrong on the ground relative to each other, and how far they may.
void AddCenters(const geo::Rigid3& true_i, const geo::Rigid3& true_j, const poses::SmoothedPose& i,
                const poses::SmoothedPose& j, Sums& sums) {
  const Vector2d center(Camera().center_x_px, Camera().center_y_px);
  const auto true_gi = camera::GroundFromPixel(Camera(), true_i, center, 0.0);
  const auto true_gj = camera::GroundFromPixel(Camera(), true_j, center, 0.0);
  const auto gi =
      camera::GroundFromPixel(Camera(), CamFromEnu(i.enu_from_body, i.position_in_enu_m), center, 0.0);
  const auto gj =
      camera::GroundFromPixel(Camera(), CamFromEnu(j.enu_from_body, j.position_in_enu_m), center, 0.0);
  if (!true_gi || !true_gj || !gi || !gj) return;
  sums.next += ((*gj - *gi) - (*true_gj - *true_gi)).head<2>().squaredNorm();
  const Eigen::Matrix<double, 2, 6> by_i = CenterByPose(i);
  const Eigen::Matrix<double, 2, 6> by_j = CenterByPose(j);
  const Matrix2d cross = by_i * i.covariance_with_next * by_j.transpose();
  const Matrix2d covariance = by_i * i.covariance * by_i.transpose() +
                              by_j * j.covariance * by_j.transpose() - cross - cross.transpose();
  const double height = true_i.TargetOriginInSource().z();
  sums.window += 3.03 * std::sqrt(std::max(0.0, 0.5 * covariance.trace())) * Camera().focal_x_px / height;
  ++sums.pairs;
}

void AddPair(const FlightTruth& truth_i, const FlightTruth& truth_j, const poses::SmoothedPose& i,
             const poses::SmoothedPose& j, Sums& sums) {
  const geo::Rigid3 true_i = CamFromEnu(truth_i.enu_from_body, truth_i.position);
  const geo::Rigid3 true_j = CamFromEnu(truth_j.enu_from_body, truth_j.position);
  AddCenters(true_i, true_j, i, j, sums);
  // A grid over the overlap says whether the search windows hold.
  for (int cell = 0; cell < 13; ++cell) {
    const bool is_center = cell == 12;
    const Vector2d pixel = is_center
                               ? Vector2d(Camera().center_x_px, Camera().center_y_px)
                               : Vector2d(5472.0 * (cell % 4 + 0.5) / 4.0, 3648.0 * (cell / 4 + 0.5) / 3.0);
    const auto truth = Carry(true_i, true_j, pixel);
    if (!truth || !Camera().IsInImage(*truth)) continue;
    const auto guess = CarryUncertain(i, j, pixel);
    if (!guess) continue;
    const Vector2d error = *truth - guess->mean;
    // Inside the 99 % ellipse, widened by the 5 px that the matcher always adds.
    const Vector2d beyond = error * std::max(0.0, 1.0 - 5.0 / std::max(1e-9, error.norm()));
    const bool inside = beyond.dot(guess->covariance.inverse() * beyond) <= 9.21;
    sums.covered += inside ? 1 : 0;
    ++sums.carried;
    if (is_center) sums.search += 3.03 * std::sqrt(0.5 * guess->covariance.trace());
    if (is_center) ++sums.centers;
  }
}

}  // namespace

PoseMetrics Measure(const AnalyticFlight& flight, const poses::SmootherOutput& output) {
  Sums sums;
  for (std::size_t k = 0; k < output.poses.size(); ++k) {
    const FlightTruth truth = flight.At(output.poses[k].t_s);
    AddPhoto(truth, output.poses[k], sums);
    if (k + 1 < output.poses.size()) {
      AddPair(truth, flight.At(output.poses[k + 1].t_s), output.poses[k], output.poses[k + 1], sums);
    }
  }
  const double n = std::max(1, sums.photos);
  const double m = std::max(1, sums.pairs);
  PoseMetrics metrics;
  metrics.position_2d_m = std::sqrt(sums.position / n);
  metrics.height_m = std::sqrt(sums.height / n);
  metrics.tilt_deg = geo::RadToDeg(std::sqrt(sums.tilt / n));
  metrics.yaw_deg = geo::RadToDeg(std::sqrt(sums.yaw / n));
  metrics.center_m = std::sqrt(sums.center / n);
  metrics.corner_m = std::sqrt(sums.corner / n);
  metrics.next_m = std::sqrt(sums.next / m);
  metrics.window_px = sums.window / m;
  metrics.search_px = sums.search / std::max(1, sums.centers);
  metrics.covered = static_cast<double>(sums.covered) / std::max(1, sums.carried);
  metrics.nees_position = sums.nees_p / n;
  metrics.nees_rotation = sums.nees_r / n;
  metrics.worst_position_m = sums.worst;
  return metrics;
}

}  // namespace skyquilt::bench
