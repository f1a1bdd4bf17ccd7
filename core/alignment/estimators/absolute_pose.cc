#include "core/alignment/estimators/absolute_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/alignment/estimators/sampler.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPoseConfidence = 0.9999;
constexpr int kPoseRefinements = 10;
constexpr double kPoseToleranceSigmas = 8.0;

std::vector<double> RealRoots(const std::array<double, 5>& polynomial) {  // of v^4 first
  const double leading = polynomial[0];
  const double largest = std::abs(*std::max_element(
      polynomial.begin(), polynomial.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  if (std::abs(leading) < 1e-12 * largest) return {};
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  for (int k = 0; k < 4; ++k) companion(0, k) = -polynomial[k + 1] / leading;
  for (int k = 0; k < 3; ++k) companion(k + 1, k) = 1.0;
  const geo::ComplexEigen eigen = geo::EigenOfSquare(companion, false);
  if (!eigen.converged) return {};
  std::vector<double> roots;
  for (int k = 0; k < 4; ++k) {
    const std::complex<double> root = eigen.values[k];
    if (std::abs(root.imag()) < 1e-4 * (1.0 + std::abs(root.real()))) roots.push_back(root.real());
  }
  return roots;
}

// Axes along a triangle.
Matrix3d Axes(const std::array<Vector3d, 3>& corners) {
  const Vector3d x = (corners[1] - corners[0]).normalized();
  const Vector3d z = x.cross(corners[2] - corners[0]).normalized();
  Matrix3d axes;
  axes << x, z.cross(x), z;
  return axes;
}

Vector2d Residual(const camera::Intrinsics& lens, const Vector3d& in_cam, const Vector2d& pixel) {
  return lens.ProjectBeyondFold(in_cam) - pixel;
}

// In sigmas, squared; infinite behind the camera.
double SquaredResidual(const camera::Intrinsics& lens, const geo::Rigid3& cam_from_world,
                       const PointObservation& observation) {
  const Vector3d in_cam = cam_from_world * observation.point_in_world;
  if (in_cam.z() <= 0.0) return std::numeric_limits<double>::infinity();
  return Residual(lens, in_cam, observation.pixel_in_image).squaredNorm() /
         (observation.sigma_px * observation.sigma_px);
}

std::vector<int> FindInliers(const camera::Intrinsics& lens, const geo::Rigid3& pose,
                             const std::vector<PointObservation>& observations) {
  std::vector<int> inliers;
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if (SquaredResidual(lens, pose, observations[k]) < kPoseToleranceSigmas * kPoseToleranceSigmas)
      inliers.push_back(static_cast<int>(k));
  }
  return inliers;
}

}  // namespace

std::vector<geo::Rigid3> PosesOfThree(const std::array<Vector3d, 3>& rays,
                                      const std::array<Vector3d, 3>& points) {
  const double aa = (points[1] - points[2]).squaredNorm(), bb = (points[0] - points[2]).squaredNorm(),
               cc = (points[0] - points[1]).squaredNorm();
  const double longest = std::max({aa, bb, cc});
  if (bb < 1e-12 * longest) return {};
  const double flat = (points[1] - points[0]).cross(points[2] - points[0]).norm();
  if (flat < 1e-3 * longest) return {};
  const double alpha = rays[1].dot(rays[2]), beta = rays[0].dot(rays[2]), gamma = rays[0].dot(rays[1]);
  const double d = (aa - cc) / bb, s = (aa + cc) / bb, ab = aa / bb, cb = cc / bb;
  const std::array<double, 5> polynomial{
      (d - 1.0) * (d - 1.0) - 4.0 * cb * alpha * alpha,
      4.0 * (d * (1.0 - d) * beta - (1.0 - s) * alpha * gamma + 2.0 * cb * alpha * alpha * beta),
      2.0 * (d * d - 1.0 + 2.0 * d * d * beta * beta + 2.0 * (1.0 - cb) * alpha * alpha -
             4.0 * s * alpha * beta * gamma + 2.0 * (1.0 - ab) * gamma * gamma),
      4.0 * (-d * (1.0 + d) * beta + 2.0 * ab * gamma * gamma * beta - (1.0 - s) * alpha * gamma),
      (1.0 + d) * (1.0 + d) - 4.0 * ab * gamma * gamma};
  std::vector<geo::Rigid3> poses;
  const Matrix3d of_points = Axes(points);
  for (const double v : RealRoots(polynomial)) {
    const double below = 2.0 * (gamma - v * alpha);
    if (std::abs(below) < 1e-12) continue;
    const double u = ((d - 1.0) * v * v - 2.0 * d * beta * v + 1.0 + d) / below;
    const double under = 1.0 + v * v - 2.0 * v * beta;
    if (under <= 0.0 || u <= 0.0 || v <= 0.0) continue;
    const double first = std::sqrt(bb / under);
    const std::array<Vector3d, 3> in_cam{first * rays[0], u * first * rays[1], v * first * rays[2]};
    const Matrix3d rotation = Axes(in_cam) * of_points.transpose();
    const geo::Rigid3 pose{Eigen::Quaterniond(rotation).normalized(), in_cam[0] - rotation * points[0]};
    if (pose.translation.allFinite()) poses.push_back(pose);
  }
  return poses;
}

geo::Rigid3 RefineResection(const camera::Intrinsics& lens, const geo::Rigid3& start,
                            const std::vector<PointObservation>& observations, const std::vector<int>& used) {
  constexpr double kWidthSigmas = 2.5, kNudge = 1e-7;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  // Turn and shift in cam: in_cam' = Exp(turn) in_cam + shift.
  const auto nudged = [](const geo::Rigid3& pose, const Vector6d& by) {
    const Eigen::Quaterniond turn = geo::RotationFromVector(by.head<3>());
    return geo::Rigid3{(turn * pose.rotation).normalized(), turn * pose.translation + by.tail<3>()};
  };
  const auto cost = [&](const geo::Rigid3& pose) {
    double sum = 0.0;
    for (const int k : used) {
      const double residual2 = SquaredResidual(lens, pose, observations[k]);
      sum += std::isfinite(residual2) ? std::log1p(residual2 / (kWidthSigmas * kWidthSigmas)) : 1e3;
    }
    return sum;
  };
  geo::Rigid3 pose = start;
  double now = cost(pose), damping = 1e-4;
  for (int step = 0; step < kPoseRefinements; ++step) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Vector6d right = Vector6d::Zero();
    for (const int k : used) {
      const PointObservation& observation = observations[k];
      const Vector3d in_cam = pose * observation.point_in_world;
      if (in_cam.z() <= 0.0) continue;
      const Vector2d residual = Residual(lens, in_cam, observation.pixel_in_image);
      Eigen::Matrix<double, 2, 3> by_point;
      for (int axis = 0; axis < 3; ++axis) {
        const double nudge = kNudge * in_cam.z();
        by_point.col(axis) =
            (Residual(lens, in_cam + nudge * Vector3d::Unit(axis), observation.pixel_in_image) - residual) /
            nudge;
      }
      Eigen::Matrix<double, 3, 6> point_by_pose;
      point_by_pose << 0.0, in_cam.z(), -in_cam.y(), 1.0, 0.0, 0.0, -in_cam.z(), 0.0, in_cam.x(), 0.0, 1.0,
          0.0, in_cam.y(), -in_cam.x(), 0.0, 0.0, 0.0, 1.0;
      const Eigen::Matrix<double, 2, 6> slope = by_point * point_by_pose;
      const double residual2 = residual.squaredNorm() / (observation.sigma_px * observation.sigma_px);
      const double weight = 1.0 / (1.0 + residual2 / (kWidthSigmas * kWidthSigmas)) /
                            (observation.sigma_px * observation.sigma_px);
      normal += weight * slope.transpose() * slope;
      right -= weight * slope.transpose() * residual;
    }
    normal.diagonal() *= 1.0 + damping;
    const geo::Rigid3 next = nudged(pose, geo::SolveSymmetric(normal, right));
    const double then = cost(next);
    if (!(then < now)) {
      damping *= 10.0;
      continue;
    }
    pose = next;
    damping = std::max(1e-9, 0.1 * damping);
    if (now - then < 1e-6 * now) break;
    now = then;
  }
  return pose;
}

std::optional<FoundPose> FindPose(const camera::Intrinsics& lens,
                                  const std::vector<PointObservation>& observations, std::uint64_t seed,
                                  const FindPoseOptions& options) {
  const int count = static_cast<int>(observations.size());
  if (count < std::max(4, options.min_inliers)) return std::nullopt;
  std::vector<Vector3d> rays;
  rays.reserve(observations.size());
  for (const PointObservation& observation : observations)
    rays.push_back(lens.Unproject(observation.pixel_in_image).normalized());
  Sampler sampler(seed);
  FoundPose best;
  int samples = options.max_samples;
  for (int s = 0; s < samples; ++s) {
    std::array<Vector3d, 3> three_rays, three_points;
    const std::array<int, 3> drawn = sampler.Distinct<3>(count);
    for (std::size_t k = 0; k < 3; ++k) {
      three_rays[k] = rays[drawn[k]];
      three_points[k] = observations[drawn[k]].point_in_world;
    }
    for (const geo::Rigid3& pose : PosesOfThree(three_rays, three_points)) {
      std::vector<int> inliers = FindInliers(lens, pose, observations);
      if (inliers.size() <= best.inliers.size()) continue;
      best = {pose, std::move(inliers)};
    }
    const double share = static_cast<double>(best.inliers.size()) / count;
    const double all_good = share * share * share;
    if (all_good > 0.9999) break;
    if (all_good > 1e-6) {
      samples = std::min(
          options.max_samples,
          std::max(10, static_cast<int>(std::log(1.0 - kPoseConfidence) / std::log(1.0 - all_good)) + 1));
    }
  }
  for (int round = 0; round < 3; ++round) {
    if (static_cast<int>(best.inliers.size()) < options.min_inliers) return std::nullopt;
    FoundPose refined;
    refined.cam_from_world = RefineResection(lens, best.cam_from_world, observations, best.inliers);
    refined.inliers = FindInliers(lens, refined.cam_from_world, observations);
    if (refined.inliers.size() < best.inliers.size()) break;
    const bool is_settled = refined.inliers.size() == best.inliers.size();
    best = std::move(refined);
    if (is_settled) break;
  }
  return best;
}

}  // namespace skyquilt::alignment
