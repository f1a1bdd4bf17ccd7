#include "core/alignment/estimators/plane_homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

constexpr double kHomographyConfidence = 0.999;
constexpr int kHomographyRefinements = 3;
constexpr double kMinDepth = 1e-3;  // of the middle's: nearer to the horizon nothing is believed

// Moves the mean to zero and the mean distance from it to sqrt(2).
template <typename Read>
std::optional<Eigen::Matrix3d> Normaliser(const std::vector<PlanePair>& pairs, Read read) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const PlanePair& pair : pairs) mean += read(pair) / static_cast<double>(pairs.size());
  double distance = 0.0;
  for (const PlanePair& pair : pairs) {
    distance += (read(pair) - mean).norm() / static_cast<double>(pairs.size());
  }
  if (distance < 1e-9) return std::nullopt;
  const double scale = std::sqrt(2.0) / distance;
  Eigen::Matrix3d normaliser;
  normaliser << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return normaliser;
}

std::vector<int> FindInliers(const std::vector<PlanePair>& pairs, const Eigen::Matrix3d& to_from,
                             double tolerance) {
  std::vector<int> inliers;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto mapped = MapPlace(to_from, pairs[k].from);
    if (mapped && (*mapped - pairs[k].to).norm() <= tolerance) inliers.push_back(static_cast<int>(k));
  }
  return inliers;
}

std::vector<PlanePair> Chosen(const std::vector<PlanePair>& pairs, const std::vector<int>& which) {
  std::vector<PlanePair> chosen;
  for (const int k : which) chosen.push_back(pairs[k]);
  return chosen;
}

}  // namespace

std::optional<Eigen::Vector2d> MapPlace(const Eigen::Matrix3d& to_from, const Eigen::Vector2d& from) {
  const Eigen::Vector3d mapped = to_from * from.homogeneous();
  if (mapped.z() < kMinDepth * to_from(2, 2)) return std::nullopt;
  return mapped.hnormalized();
}

std::optional<Eigen::Matrix3d> FitHomography(const std::vector<PlanePair>& pairs) {
  if (pairs.size() < 4) return std::nullopt;
  const auto normal_from = Normaliser(pairs, [](const PlanePair& pair) { return pair.from; });
  const auto normal_to = Normaliser(pairs, [](const PlanePair& pair) { return pair.to; });
  if (!normal_from || !normal_to) return std::nullopt;
  Eigen::Matrix<double, 9, 9> square = Eigen::Matrix<double, 9, 9>::Zero();
  for (const PlanePair& pair : pairs) {
    const Eigen::Vector3d from = *normal_from * pair.from.homogeneous();
    const Eigen::Vector3d to = *normal_to * pair.to.homogeneous();
    Eigen::Matrix<double, 2, 9> rows;
    rows << Eigen::RowVector3d::Zero(), -from.transpose(), to.y() * from.transpose(),  //
        from.transpose(), Eigen::RowVector3d::Zero(), -to.x() * from.transpose();
    square += rows.transpose() * rows;
  }
  const geo::SymmetricEigen eigen = geo::EigenOfSymmetric(square);
  // A second vanishing eigenvalue: the pairs leave the map open.
  if (!eigen.converged || eigen.values[1] < 1e-12 * eigen.values[8]) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = eigen.vectors.col(0);
  const Eigen::Matrix3d normal = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  Eigen::Matrix3d to_from = normal_to->inverse() * normal * *normal_from;
  if (std::abs(to_from(2, 2)) < 1e-12 * to_from.norm()) return std::nullopt;
  to_from /= to_from(2, 2);
  return to_from;
}

std::optional<RobustFit> RobustHomography(const std::vector<PlanePair>& pairs, double tolerance,
                                          int max_trials) {
  const auto count = static_cast<int>(pairs.size());
  if (count < 8) return std::nullopt;
  std::vector<cv::Point2d> from, to;
  for (const PlanePair& pair : pairs) {
    from.emplace_back(pair.from.x(), pair.from.y());
    to.emplace_back(pair.to.x(), pair.to.y());
  }
  const cv::Mat found = cv::findHomography(from, to, cv::USAC_MAGSAC, tolerance, cv::noArray(), max_trials,
                                           kHomographyConfidence);
  if (found.empty()) return std::nullopt;
  RobustFit best;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) best.to_from(r, c) = found.at<double>(r, c);
  }
  if (!best.to_from.allFinite() || std::abs(best.to_from(2, 2)) < 1e-12 * best.to_from.norm())
    return std::nullopt;
  best.to_from /= best.to_from(2, 2);
  best.inliers = FindInliers(pairs, best.to_from, tolerance);
  for (int round = 0; round < kHomographyRefinements && best.inliers.size() >= 4; ++round) {
    const auto refined = FitHomography(Chosen(pairs, best.inliers));
    if (!refined) break;
    std::vector<int> inliers = FindInliers(pairs, *refined, tolerance);
    if (inliers.size() < best.inliers.size()) break;
    best = {*refined, std::move(inliers)};
  }
  if (static_cast<double>(best.inliers.size()) <= 5.9 + 0.22 * count) return std::nullopt;
  return best;
}

}  // namespace skyquilt::alignment
