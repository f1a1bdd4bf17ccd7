#include "core/alignment/estimators/similarity.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/alignment/estimators/sampler.h"
#include "core/base/median.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kSamples = 400;
constexpr double kHoldsSigmas = 4.0;
constexpr double kMinHeld = 0.5;
constexpr double kBelievedSigmas = 3.0;
constexpr double kHeldUpRad = 0.003;
constexpr int kSteps = 15;

// Two places and the vertical: turn about it, scale and shift.
std::optional<Similarity3> OfTwo(const PlacePair& a, const PlacePair& b, const Eigen::Quaterniond& level) {
  const Vector3d source = level * (b.in_source - a.in_source);
  const Vector3d target = b.in_target - a.in_target;
  const double from = source.head<2>().norm(), to = target.head<2>().norm();
  if (from < 1e-9 || to < 1e-9) return std::nullopt;
  Similarity3 fitted;
  fitted.scale = to / from;
  const double turn = std::atan2(target.y(), target.x()) - std::atan2(source.y(), source.x());
  fitted.rotation = (Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vector3d::UnitZ())) * level).normalized();
  fitted.shift = 0.5 * (a.in_target + b.in_target) -
                 fitted.scale * (fitted.rotation * (0.5 * (a.in_source + b.in_source)));
  return fitted;
}

double HorizontalResidual(const Similarity3& similarity, const PlacePair& pair) {
  return (similarity * pair.in_source - pair.in_target).head<2>().norm();
}

// Half of the target's places lie further than this from their middle, horizontally.
double SpreadOf(const std::vector<PlacePair>& pairs) {
  std::vector<Eigen::Vector2d> places;
  for (const PlacePair& pair : pairs) places.push_back(pair.in_target.head<2>());
  const Eigen::Vector2d middle = MedianByAxis(places);
  return MedianOf(pairs, [&](const PlacePair& pair) { return (pair.in_target.head<2>() - middle).norm(); });
}

// Gauss-Newton over what holds; seven unknowns, robust weights.
Similarity3 Refine(const Similarity3& start, const std::vector<PlacePair>& pairs,
                   const std::vector<bool>& holds, double spread_sigmas,
                   const std::optional<UpDirection>& up) {
  using Vector7d = Eigen::Matrix<double, 7, 1>;
  Similarity3 now = start;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
    Vector7d right = Vector7d::Zero();
    // Nudged: turn about the target's axes round the middle of the source, scale by its logarithm, shift.
    Vector3d middle = Vector3d::Zero();
    double count = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (holds[k]) middle += now * pairs[k].in_source, count += 1.0;
    }
    middle /= std::max(1.0, count);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (!holds[k]) continue;
      const Vector3d at = now * pairs[k].in_source;
      const Vector3d arm = at - middle;
      const Vector3d residual = at - pairs[k].in_target;
      Eigen::Matrix<double, 3, 7> slope;
      slope << 0.0, arm.z(), -arm.y(), arm.x(), 1.0, 0.0, 0.0, -arm.z(), 0.0, arm.x(), arm.y(), 0.0, 1.0, 0.0,
          arm.y(), -arm.x(), 0.0, arm.z(), 0.0, 0.0, 1.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double sigma = spread_sigmas * pairs[k].sigma[axis];
        if (!std::isfinite(sigma)) continue;
        const double scaled = residual[axis] / sigma / 3.0;
        const double weight = 1.0 / (sigma * sigma) / (1.0 + scaled * scaled);
        normal += weight * slope.row(axis).transpose() * slope.row(axis);
        right -= weight * slope.row(axis).transpose() * residual[axis];
      }
    }
    if (up) {
      const Vector3d leaning = now.rotation * up->in_source;  // should be +z
      Eigen::Matrix<double, 2, 7> slope = Eigen::Matrix<double, 2, 7>::Zero();
      slope(0, 1) = leaning.z(), slope(0, 2) = -leaning.y();
      slope(1, 0) = -leaning.z(), slope(1, 2) = leaning.x();
      const double weight = 1.0 / (up->sigma_rad * up->sigma_rad);
      normal += weight * slope.transpose() * slope;
      right -= weight * slope.transpose() * leaning.head<2>();
    }
    normal.diagonal().array() += 1e-12 * normal.diagonal().maxCoeff() + 1e-15;
    const Vector7d by = geo::SolveSymmetric(normal, right);
    if (!by.allFinite()) break;
    const Eigen::Quaterniond turn = geo::RotationFromVector(by.head<3>());
    const double grow = std::exp(std::clamp(by[3], -1.0, 1.0));
    now.shift = grow * (turn * (now.shift - middle)) + middle + by.tail<3>();
    now.rotation = (turn * now.rotation).normalized();
    now.scale *= grow;
    if (by.head<3>().norm() < 1e-9 && std::abs(by[3]) < 1e-9) break;
  }
  return now;
}

}  // namespace

geo::Rigid3 Similarity3::Moved(const geo::Rigid3& cam_from_source) const {
  return geo::Rigid3::FromRotationAndTargetOrigin(
      (cam_from_source.rotation * rotation.conjugate()).normalized(),
      *this * cam_from_source.TargetOriginInSource());
}

std::optional<Similarity3> FitSimilarity3(const std::vector<PlacePair>& pairs) {
  if (pairs.size() < 3) return std::nullopt;
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  for (const PlacePair& pair : pairs) {
    from += pair.in_source;
    to += pair.in_target;
  }
  const auto count = static_cast<double>(pairs.size());
  from /= count;
  to /= count;
  Matrix3d cross = Matrix3d::Zero();
  double square = 0.0;
  for (const PlacePair& pair : pairs) {
    cross += (pair.in_target - to) * (pair.in_source - from).transpose();
    square += (pair.in_source - from).squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // On one line they turn freely about it.
  if (square <= 0.0 || svd.singularValues()[1] < 1e-9 * svd.singularValues()[0]) return std::nullopt;
  Vector3d signs = Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs.z() = -1.0;
  Similarity3 fitted;
  fitted.rotation =
      Eigen::Quaterniond(Matrix3d(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()))
          .normalized();
  fitted.scale = svd.singularValues().dot(signs) / square;
  fitted.shift = to - fitted.scale * (fitted.rotation * from);
  if (!(fitted.scale > 0.0)) return std::nullopt;
  return fitted;
}

std::optional<FittedSimilarity> FitRobustly(const std::vector<PlacePair>& pairs,
                                            const std::optional<UpDirection>& up, double max_residual_share) {
  const int count = static_cast<int>(pairs.size());
  if (count < (up ? 2 : 3)) return std::nullopt;
  const Eigen::Quaterniond level = up ? geo::RotationToZ(up->in_source) : Eigen::Quaterniond::Identity();
  Sampler sampler(static_cast<std::uint64_t>(count));
  std::optional<Similarity3> best;
  double least = 0.0;
  for (int s = 0; s < kSamples; ++s) {
    std::optional<Similarity3> proposed;
    if (up) {
      const std::array<int, 2> two = sampler.Distinct<2>(count);
      proposed = OfTwo(pairs[two[0]], pairs[two[1]], level);
    } else {
      std::vector<PlacePair> three;
      for (const int k : sampler.Distinct<3>(count)) three.push_back(pairs[k]);
      proposed = FitSimilarity3(three);
    }
    if (!proposed) continue;
    const double median = MedianOf(pairs, [&](const PlacePair& pair) {
      return HorizontalResidual(*proposed, pair) / pair.sigma.head<2>().mean();
    });
    if (best && median >= least) continue;
    least = median;
    best = proposed;
  }
  if (!best) return std::nullopt;
  FittedSimilarity fitted;
  fitted.target_from_source = *best;
  double spread_sigmas = std::max(1.0, least / kMedianInPlane);
  for (int round = 0; round < 4; ++round) {
    fitted.holds.assign(pairs.size(), false);
    fitted.held = 0;
    std::vector<double> residuals, sigmas;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const double sigma = pairs[k].sigma.head<2>().mean();
      const double residual = HorizontalResidual(fitted.target_from_source, pairs[k]);
      if (residual > kHoldsSigmas * spread_sigmas * sigma) continue;
      fitted.holds[k] = true;
      ++fitted.held;
      residuals.push_back(residual);
      sigmas.push_back(residual / sigma);
    }
    if (fitted.held < kMinHeld * count) return std::nullopt;
    fitted.median_residual = Median(std::move(residuals));
    if (fitted.median_residual > max_residual_share * SpreadOf(pairs)) return std::nullopt;
    const double now = std::max(1.0, Median(std::move(sigmas)) / kMedianInPlane);
    spread_sigmas = std::min(spread_sigmas, now);
    fitted.spread_sigmas = spread_sigmas;
    if (round == 3) break;
    // Places that are worse than they claim err together: what they seem to say of a tilt is their own
    // bending.
    std::optional<UpDirection> held_up = up;
    if (held_up && spread_sigmas > kBelievedSigmas) held_up->sigma_rad = kHeldUpRad;
    fitted.target_from_source =
        Refine(fitted.target_from_source, pairs, fitted.holds, spread_sigmas, held_up);
  }
  return fitted;
}

}  // namespace skyquilt::alignment
