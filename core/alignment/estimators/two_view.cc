#include "core/alignment/estimators/two_view.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/alignment/estimators/epipolar.h"
#include "core/alignment/estimators/sampler.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMaxProposals = 200;
constexpr double kNearShare = 0.08;   // of a width: tolerance around the similarity of one match
constexpr double kLooseShare = 0.15;  // tolerance around the motion fitted to those
constexpr double kMaxLog2Scale = 0.8;
constexpr double kMaxTurnRad = 0.7;
constexpr int kMaxHomographies = 150;
constexpr int kMaxEssentials = 80;
constexpr double kFlatShare = 0.85;  // of the loose inliers
constexpr double kConfidence = 0.999;
constexpr double kNoParallaxRad = 0.005;
constexpr double kOtherPoseRad = 0.03;
constexpr double kNearlyAsWell = 0.9;
constexpr int kRefinements = 8;

// Inliers of one rough motion of the picture: of the proposed motions, the one with most inliers.
std::vector<int> FollowLoosely(const PhotoFeatures& first, const PhotoFeatures& second,
                               const camera::Intrinsics& second_lens,
                               const std::vector<KeypointMatch>& matches) {
  const int count = static_cast<int>(matches.size());
  std::vector<Vector2d> from, to;
  std::vector<double> turn, grown;
  for (const KeypointMatch& match : matches) {
    const Keypoint& a = first.keypoints[match.first];
    const Keypoint& b = second.keypoints[match.second];
    from.emplace_back(a.x_px, a.y_px);
    to.emplace_back(b.x_px, b.y_px);
    turn.push_back(b.angle_rad - a.angle_rad);
    grown.push_back(std::log2(b.scale_px / std::max(1e-3F, a.scale_px)));
  }
  const double near_px = kNearShare * std::max(second_lens.width_px, second_lens.height_px);
  std::vector<int> best;
  const int step = std::max(1, count / kMaxProposals);
  for (int k = 0; k < count; k += step) {
    const double scale = std::exp2(grown[k]);
    const double c = scale * std::cos(turn[k]), s = scale * std::sin(turn[k]);
    std::vector<int> inliers;
    for (int m = 0; m < count; ++m) {
      const Vector2d apart = from[m] - from[k];
      const Vector2d expected =
          to[k] + Vector2d(c * apart.x() - s * apart.y(), s * apart.x() + c * apart.y());
      if ((to[m] - expected).squaredNorm() > near_px * near_px) continue;
      if (std::abs(grown[m] - grown[k]) > kMaxLog2Scale) continue;
      if (std::abs(std::remainder(turn[m] - turn[k], 2.0 * std::numbers::pi)) > kMaxTurnRad) continue;
      inliers.push_back(m);
    }
    if (inliers.size() > best.size()) best = std::move(inliers);
  }
  if (best.size() < 6) return {};
  // An affine motion through the inliers brings in those further away, where one similarity does not reach.
  const double loose_px = kLooseShare / kNearShare * near_px;
  for (int round = 0; round < 2; ++round) {
    Matrix3d normal = Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    for (const int m : best) {
      const Vector3d a = from[m].homogeneous();
      normal += a * a.transpose();
      right += a * to[m].transpose();
    }
    normal.diagonal().array() += 1e-9 * normal.trace();
    const Eigen::Matrix<double, 3, 2> fitted = geo::SolveSymmetric(normal, right);
    const Eigen::Matrix2d linear = fitted.topRows<2>().transpose();
    const Vector2d shift = fitted.row(2).transpose();
    best.clear();
    for (int m = 0; m < count; ++m) {
      const Vector2d moved = linear * from[m] + shift;
      if ((to[m] - moved).norm() < loose_px) best.push_back(m);
    }
    if (best.size() < 6) return {};
  }
  return best;
}

// Samples that will do for a share of good matches.
int EnoughSamples(double share, int sample, int most) {
  const double all_good = std::pow(share, sample);
  if (all_good > 0.999) return 1;
  if (all_good < 1e-6) return most;
  return std::min(most, static_cast<int>(std::log(1.0 - kConfidence) / std::log(1.0 - all_good)) + 1);
}

// Of `among`, the pairs whose squared error by a homography or an essential matrix is small enough.
template <double (*kError2)(const Matrix3d&, const RayPair&)>
std::vector<int> Near(const Matrix3d& matrix, const std::vector<RayPair>& pairs,
                      const std::vector<int>& among, double tolerance) {
  std::vector<int> near;
  for (const int k : among) {
    if (kError2(matrix, pairs[k]) < tolerance * tolerance) near.push_back(k);
  }
  return near;
}

RobustFit FindHomography(const std::vector<RayPair>& pairs, const std::vector<int>& among, double tolerance,
                         Sampler& sampler) {
  RobustFit best;
  int samples = kMaxHomographies;
  const auto take = [&](const Matrix3d& homography) {
    std::vector<int> inliers = Near<TransferError2>(homography, pairs, among, tolerance);
    if (inliers.size() <= best.inliers.size()) return false;
    best = {homography, std::move(inliers)};
    return true;
  };
  for (int s = 0; s < samples; ++s) {
    std::vector<int> four;
    for (const int k : sampler.Distinct<4>(static_cast<int>(among.size()))) {
      four.push_back(among[k]);
    }
    const std::optional<Matrix3d> homography = FitHomography(pairs, four);
    if (!homography || !take(*homography)) continue;
    for (int round = 0; round < 3; ++round) {
      const std::optional<Matrix3d> refitted = FitHomography(pairs, best.inliers);
      if (!refitted || !take(*refitted)) break;
    }
    const double share = static_cast<double>(best.inliers.size()) / static_cast<double>(among.size());
    samples = std::min(samples, EnoughSamples(share, 4, kMaxHomographies));
  }
  return best;
}

std::optional<geo::Rigid3> FindByFive(const std::vector<RayPair>& pairs, const std::vector<int>& among,
                                      double tolerance, Sampler& sampler) {
  Matrix3d best = Matrix3d::Zero();
  std::vector<int> inliers;
  int samples = kMaxEssentials;
  for (int s = 0; s < samples; ++s) {
    std::array<RayPair, 5> five;
    const std::array<int, 5> drawn = sampler.Distinct<5>(static_cast<int>(among.size()));
    for (std::size_t k = 0; k < 5; ++k) {
      five[k] = pairs[among[drawn[k]]];
    }
    for (const Matrix3d& essential : EssentialsOfFive(five)) {
      std::vector<int> near = Near<Sampson2>(essential, pairs, among, tolerance);
      if (near.size() <= inliers.size()) continue;
      inliers = std::move(near);
      best = essential;
    }
    const double share = static_cast<double>(inliers.size()) / static_cast<double>(among.size());
    samples = std::min(samples, EnoughSamples(share, 5, kMaxEssentials));
  }
  if (inliers.size() < 8) return std::nullopt;
  return PoseOfEssential(best, pairs, inliers);
}

// The turn that brings the first's rays to the second's (Wahba's problem).
Eigen::Quaterniond FitTurn(const std::vector<RayPair>& pairs, const std::vector<int>& used) {
  Matrix3d cross = Matrix3d::Zero();
  for (const int k : used) {
    const RayPair& pair = pairs[k];
    cross += pair.second.homogeneous().normalized() * pair.first.homogeneous().normalized().transpose();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return Eigen::Quaterniond(
             Matrix3d(svd.matrixU() * Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose()))
      .normalized();
}

// Near its epipolar line and before both cameras.
std::vector<int> Fitting(const geo::Rigid3& pose, const std::vector<RayPair>& pairs,
                         const std::vector<int>& among, double tolerance) {
  std::vector<int> fitting = Near<Sampson2>(EssentialOfPose(pose), pairs, among, tolerance);
  std::erase_if(fitting, [&](int k) {
    const std::optional<Vector2d> depths = Depths(pose, pairs[k]);
    return !depths || depths->x() <= 0.0 || depths->y() <= 0.0;
  });
  return fitting;
}

double MedianAngle(const Eigen::Quaterniond& rotation, const std::vector<RayPair>& pairs,
                   const std::vector<int>& used) {
  return MedianOf(used, [&](int k) {
    const Vector3d a = (rotation * pairs[k].first.homogeneous()).normalized();
    const Vector3d b = pairs[k].second.homogeneous().normalized();
    return std::atan2(a.cross(b).norm(), a.dot(b));
  });
}

struct Candidate {
  geo::Rigid3 pose;
  std::vector<int> fitting;
  double frontal = 0.0;
};

// How squarely both cameras look at the plane through the points, 0 (along it) to 1. What flat ground under a
// camera that moved sideways leaves open is another ground, seen along it, under a camera that turned.
double Frontal(const geo::Rigid3& pose, const std::vector<RayPair>& pairs, const std::vector<int>& used) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const int k : used) {
    const RayPair& pair = pairs[k];
    const std::optional<Vector2d> depths = Depths(pose, pair);
    if (!depths || depths->x() <= 0.0) continue;
    // The inverse depth of a plane's points is linear in the ray.
    const Vector3d ray = pair.first.homogeneous();
    normal += ray * ray.transpose();
    right += ray / depths->x();
  }
  normal.diagonal().array() += 1e-12;
  const Vector3d of_plane = Vector3d(geo::SolveSymmetric(normal, right)).normalized();
  return std::min(std::abs(of_plane.z()), std::abs((pose.rotation * of_plane).z()));
}

void TakeMatches(const std::vector<KeypointMatch>& matches, const std::vector<int>& chosen, PhotoPair& view) {
  std::vector<int> sorted = chosen;
  std::sort(sorted.begin(), sorted.end());
  for (const int k : sorted) view.matches.push_back(matches[k]);
}

}  // namespace

KeypointRays RaysOf(const Registration& input, int most, int threads) {
  KeypointRays rays(input.Photos());
  ParallelFor(input.Photos(), threads, [&](std::size_t i) {
    const PhotoFeatures* features = input.features[i];
    if (!features) return;
    const camera::Intrinsics& lens = input.LensOf(i);
    const std::size_t count = std::min<std::size_t>(most, features->keypoints.size());
    rays[i].reserve(count);
    for (std::size_t k = 0; k < count; ++k) {
      const Keypoint& keypoint = features->keypoints[k];
      rays[i].emplace_back(lens.Unproject({keypoint.x_px, keypoint.y_px}).head<2>());
    }
  });
  return rays;
}

std::optional<PhotoPair> VerifyTwoViews(const Registration& input, const KeypointRays& rays,
                                        const PhotoPair& compared, double tolerance_sigmas) {
  const std::vector<KeypointMatch>& matches = compared.matches;
  const int least = kMinTwoViewMatches;
  if (static_cast<int>(matches.size()) < least) return std::nullopt;
  const PhotoFeatures& first = *input.features[compared.first];
  const PhotoFeatures& second = *input.features[compared.second];
  const camera::Intrinsics& first_lens = input.LensOf(compared.first);
  const camera::Intrinsics& second_lens = input.LensOf(compared.second);
  const std::vector<int> loose = FollowLoosely(first, second, second_lens, matches);
  if (static_cast<int>(loose.size()) < least) return std::nullopt;
  std::vector<RayPair> pairs;
  pairs.reserve(matches.size());
  for (const KeypointMatch& match : matches) {
    pairs.push_back({rays[compared.first][match.first], rays[compared.second][match.second]});
  }
  const double tolerance = tolerance_sigmas * std::hypot(first.sigma_px / first_lens.MeanFocalPx(),
                                                         second.sigma_px / second_lens.MeanFocalPx());
  Sampler sampler(static_cast<std::uint64_t>(compared.first) * 1000003U +
                  static_cast<std::uint64_t>(compared.second));
  const RobustFit flat = FindHomography(pairs, loose, 2.0 * tolerance, sampler);
  PhotoPair view{compared.first, compared.second, {}, {}};
  if (static_cast<int>(flat.inliers.size()) >= least) {
    const Eigen::Quaterniond turn = FitTurn(pairs, flat.inliers);
    const double angle_rad = MedianAngle(turn, pairs, flat.inliers);
    if (angle_rad < kNoParallaxRad) {
      view.poses.push_back({turn, Vector3d::Zero()});
      view.angle_rad = angle_rad;
      TakeMatches(matches, flat.inliers, view);
      return view;
    }
  }
  const bool is_flat =
      static_cast<double>(flat.inliers.size()) > kFlatShare * static_cast<double>(loose.size());
  std::vector<geo::Rigid3> starts;
  if (static_cast<int>(flat.inliers.size()) >= least) {
    starts = PosesOfHomography(flat.second_from_first, pairs, flat.inliers);
  }
  if (!is_flat || starts.empty()) {
    if (const std::optional<geo::Rigid3> found = FindByFive(pairs, loose, tolerance, sampler)) {
      starts.push_back(*found);
    }
  }
  std::vector<Candidate> candidates;
  for (const geo::Rigid3& start : starts) {
    if (start.translation.squaredNorm() < 0.5) continue;
    Candidate candidate{start, Fitting(start, pairs, loose, 4.0 * tolerance)};
    for (const double width : {2.0 * tolerance, tolerance}) {
      if (static_cast<int>(candidate.fitting.size()) < least) break;
      candidate.pose = RefinePose(candidate.pose, pairs, candidate.fitting, 0.5 * width, kRefinements);
      candidate.fitting = Fitting(candidate.pose, pairs, loose, width);
    }
    if (static_cast<int>(candidate.fitting.size()) >= least) candidates.push_back(std::move(candidate));
  }
  if (candidates.empty()) return std::nullopt;
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.fitting.size() > b.fitting.size();
  });
  // Of those that fit nearly as well as the best, the likelier first; the other photos decide in the end.
  const double enough = kNearlyAsWell * static_cast<double>(candidates.front().fitting.size());
  std::erase_if(candidates,
                [&](const Candidate& one) { return static_cast<double>(one.fitting.size()) < enough; });
  for (Candidate& one : candidates) one.frontal = Frontal(one.pose, pairs, one.fitting);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.frontal > b.frontal; });
  const Candidate& best = candidates.front();
  view.poses.push_back(best.pose);
  for (std::size_t k = 1; k < candidates.size() && view.poses.size() < 2; ++k) {
    const Candidate& other = candidates[k];
    if (other.pose.rotation.angularDistance(best.pose.rotation) > kOtherPoseRad)
      view.poses.push_back(other.pose);
  }
  view.angle_rad = MedianAngle(best.pose.rotation, pairs, best.fitting);
  TakeMatches(matches, best.fitting, view);
  return view;
}

}  // namespace skyquilt::alignment
