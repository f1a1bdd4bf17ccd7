#include "core/alignment/from_records/register_by_resection.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/alignment/matching/guided_matching.h"
#include "core/base/parallel_for.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kMaxNeighbours = 12;
constexpr double kReachWidths = 1.6;  // further apart than this no two photos show the same
constexpr double kTolerancesShare[] = {0.05, 0.03, 0.015, 0.008};  // of the width, step by step
constexpr std::size_t kMaxGuesses = 400;
constexpr int kSteps = 6;
constexpr std::size_t kMinInliers = 12;
constexpr double kSigmaTiltRad = 0.1;  // of an aircraft's own angles
constexpr double kSigmaHeightShare = 0.1;
constexpr int kMinMatchesPerPair = 6;
constexpr double kMinRadiusShare = 0.15;
constexpr double kExpectedErrors = 4.0;
constexpr int kFeaturesAnywhere = 1000;
constexpr int kMaxPasses = 4;

struct Candidate {
  int neighbour = 0;
  KeypointMatch match;
  Eigen::Vector3d place_in_enu;

  std::complex<double> Place() const { return {place_in_enu.x(), place_in_enu.y()}; }
};

// The nearest aligned photos, and those next in time.
std::vector<int> Neighbours(const MatchingInput& input, const std::vector<char>& is_aligned,
                            const std::vector<Eigen::Vector2d>& middles, int lost) {
  const int count = static_cast<int>(input.views.size());
  std::vector<std::pair<double, int>> by_distance;
  std::vector<int> chosen;
  for (int i = 0; i < count; ++i) {
    if (!is_aligned[i] || i == lost) continue;
    const double apart_m = (middles[i] - middles[lost]).norm();
    if (std::abs(i - lost) <= 2) {
      chosen.push_back(i);
    } else if (apart_m < kReachWidths * input.views[i].WidthM()) {
      by_distance.emplace_back(apart_m, i);
    }
  }
  std::sort(by_distance.begin(), by_distance.end());
  for (const auto& [apart_m, i] : by_distance) {
    if (chosen.size() >= kMaxNeighbours) break;
    chosen.push_back(i);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<Candidate> Collect(const MatchingInput& input, const std::vector<GroundView>& projected,
                               const Relief& relief, const std::vector<int>& neighbours, int lost,
                               const MatchWindow& window) {
  std::vector<Candidate> candidates;
  for (const int i : neighbours) {
    for (const KeypointMatch& match : MatchOnGround(projected[i], projected[lost], {}, window)) {
      const Keypoint& seen = input.features[i]->keypoints[match.first];
      Candidate candidate{i, match, {}};
      if (MeetGround(input.views[i], relief, {seen.x_px, seen.y_px}, &candidate.place_in_enu)) {
        candidates.push_back(candidate);
      }
    }
  }
  return candidates;
}

// The lost photo's pose as it moves over level ground: turned about the vertical and shifted.
geo::Rigid3 Moved(const geo::Rigid3& cam_from_enu, const GroundSimilarity& motion) {
  const Eigen::Vector3d center = cam_from_enu.TargetOriginInSource();
  const std::complex<double> now = motion * std::complex<double>(center.x(), center.y());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::arg(motion.turn_and_scale), Eigen::Vector3d::UnitZ()));
  return geo::Rigid3::FromRotationAndTargetOrigin((cam_from_enu.rotation * turn.conjugate()).normalized(),
                                                  {now.real(), now.imag(), center.z()});
}

// One match is enough for a guess of turn and place; the guess with most inliers wins.
std::optional<GroundSimilarity> GuessMotion(const std::vector<GroundView>& projected,
                                            const std::vector<Candidate>& candidates, int lost,
                                            double tolerance_m) {
  const std::vector<GroundKeypoint>& of_lost = *projected[lost].projected;
  const std::size_t step = std::max<std::size_t>(1, candidates.size() / kMaxGuesses);
  std::size_t most = 0;
  std::optional<GroundSimilarity> best;
  for (std::size_t k = 0; k < candidates.size(); k += step) {
    const GroundKeypoint& from = of_lost[candidates[k].match.second];
    const GroundKeypoint& to = (*projected[candidates[k].neighbour].projected)[candidates[k].match.first];
    for (const double turn : {0.0, static_cast<double>(to.angle_rad - from.angle_rad)}) {
      const std::complex<double> rotor = std::polar(1.0, turn);
      const GroundSimilarity motion{rotor, candidates[k].Place() - rotor * from.place};
      std::size_t inliers = 0;
      for (const Candidate& other : candidates) {
        inliers += std::abs(motion * of_lost[other.match.second].place - other.Place()) < tolerance_m;
      }
      if (inliers <= most) continue;
      most = inliers;
      best = motion;
    }
  }
  return best;
}

class Resection {
 public:
  Resection(const MatchingInput& input, const std::vector<Candidate>& candidates, int lost)
      : lens_(input.views[lost].intrinsics),
        height_m_(input.views[lost].height_above_ground_m),
        candidates_(candidates) {
    for (const Candidate& candidate : candidates) {
      const Keypoint& seen = input.features[lost]->keypoints[candidate.match.second];
      pixels_.emplace_back(seen.x_px, seen.y_px);
    }
  }

  Eigen::Vector2d ResidualPx(const geo::Rigid3& cam_from_enu, std::size_t k) const {
    const Eigen::Vector3d in_cam = cam_from_enu * candidates_[k].place_in_enu;
    if (in_cam.z() < 1e-3) return Eigen::Vector2d::Constant(1e6);
    return lens_.ProjectBeyondFold(in_cam) - pixels_[k];
  }

  std::vector<int> FindInliers(const geo::Rigid3& cam_from_enu, double tolerance_px) const {
    std::vector<int> inliers;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (ResidualPx(cam_from_enu, k).norm() < tolerance_px) inliers.push_back(static_cast<int>(k));
    }
    return inliers;
  }

  // Gauss-Newton over the inliers; tilt and height held by `start` as loosely as bad records are.
  geo::Rigid3 Refine(const geo::Rigid3& start, const geo::Rigid3& believed, const std::vector<int>& inliers,
                     double sigma_px) const {
    geo::Rigid3 pose = start;
    for (int step = 0; step < kSteps; ++step) {
      Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
      const auto add = [&](const Eigen::Matrix<double, 1, 6>& slope, double residual, double sigma) {
        normal += slope.transpose() * slope / (sigma * sigma);
        right -= slope.transpose() * residual / (sigma * sigma);
      };
      for (const int k : inliers) {
        const Eigen::Vector2d residual = ResidualPx(pose, k);
        Eigen::Matrix<double, 2, 6> slope;
        for (int axis = 0; axis < 6; ++axis) {
          Eigen::Matrix<double, 6, 1> nudge = Eigen::Matrix<double, 6, 1>::Zero();
          nudge[axis] = axis < 3 ? 1e-5 : 1e-5 * height_m_;
          slope.col(axis) = (ResidualPx(Nudged(pose, nudge), k) - residual) / nudge[axis];
        }
        add(slope.row(0), residual.x(), sigma_px);
        add(slope.row(1), residual.y(), sigma_px);
      }
      // In enu: the axis leans by turns about east and north.
      const Eigen::Vector3d axis_now = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d axis_believed = believed.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d lean = axis_believed.cross(axis_now);
      for (int axis = 0; axis < 2; ++axis) {
        add(Eigen::Matrix<double, 1, 6>::Unit(axis), lean[axis], kSigmaTiltRad);
      }
      const double climbed_m = pose.TargetOriginInSource().z() - believed.TargetOriginInSource().z();
      add(Eigen::Matrix<double, 1, 6>::Unit(5), climbed_m, kSigmaHeightShare * height_m_);
      pose = Nudged(pose, geo::SolveSymmetric(normal, right));
    }
    return pose;
  }

 private:
  // Turns about the enu axes (radians), then shifts the centre (metres).
  static geo::Rigid3 Nudged(const geo::Rigid3& pose, const Eigen::Matrix<double, 6, 1>& by) {
    const Eigen::Quaterniond turn = geo::RotationFromVector(by.head<3>());
    return geo::Rigid3::FromRotationAndTargetOrigin((pose.rotation * turn.conjugate()).normalized(),
                                                    pose.TargetOriginInSource() + by.tail<3>());
  }

  const camera::Intrinsics& lens_;
  double height_m_;
  const std::vector<Candidate>& candidates_;
  std::vector<Eigen::Vector2d> pixels_;
};

std::vector<VerifiedPair> ToVerifiedPairs(const std::vector<Candidate>& candidates,
                                          const std::vector<int>& inliers, int lost) {
  std::vector<VerifiedPair> pairs;
  for (const int k : inliers) {
    const Candidate& candidate = candidates[k];
    const bool lost_is_first = lost < candidate.neighbour;
    const int first = lost_is_first ? lost : candidate.neighbour;
    const int second = lost_is_first ? candidate.neighbour : lost;
    if (pairs.empty() || pairs.back().first != first || pairs.back().second != second) {
      pairs.push_back({first, second, {}, {}, 0.0});
    }
    pairs.back().matches.push_back(
        lost_is_first ? KeypointMatch{candidate.match.second, candidate.match.first} : candidate.match);
  }
  std::erase_if(pairs, [](const VerifiedPair& pair) {
    return static_cast<int>(pair.matches.size()) < kMinMatchesPerPair;
  });
  return pairs;
}

// The pose with most inliers, when there are more than chance explains.
std::optional<ResectedPhoto> Resect(const MatchingInput& input, const std::vector<GroundView>& projected,
                                    const std::vector<Candidate>& candidates, int lost,
                                    double search_area_m2) {
  if (candidates.size() < kMinInliers) return std::nullopt;
  const View& view = input.views[lost];
  const double width_px = view.intrinsics.width_px;
  const std::optional<GroundSimilarity> motion =
      GuessMotion(projected, candidates, lost, kTolerancesShare[0] * view.WidthM());
  if (!motion) return std::nullopt;
  const Resection resection(input, candidates, lost);
  const geo::Rigid3 believed = Moved(view.cam_from_enu, *motion);
  geo::Rigid3 pose = believed;
  std::vector<int> inliers;
  for (const double share : kTolerancesShare) {
    inliers = resection.FindInliers(pose, share * width_px);
    if (inliers.size() < kMinInliers) return std::nullopt;
    pose = resection.Refine(pose, believed, inliers, 0.3 * share * width_px);
  }
  const double last_share = kTolerancesShare[std::size(kTolerancesShare) - 1];
  inliers = resection.FindInliers(pose, last_share * width_px);
  const double tolerance_m = last_share * view.WidthM();
  const double by_chance =
      std::numbers::pi * tolerance_m * tolerance_m / search_area_m2 * static_cast<double>(candidates.size());
  const double enough = std::max<double>(kMinInliers, by_chance + 5.0 * std::sqrt(by_chance) + 8.0);
  if (static_cast<double>(inliers.size()) < enough) return std::nullopt;
  ResectedPhoto resected{lost, pose, ToVerifiedPairs(candidates, inliers, lost)};
  if (resected.links.empty()) return std::nullopt;
  return resected;
}

std::size_t MatchesOf(const ResectedPhoto& one) {
  std::size_t matches = 0;
  for (const VerifiedPair& pair : one.links) matches += pair.matches.size();
  return matches;
}

// A photo that was far off is found by what lies within reach of its old place, which may be one corner of it
// and holds the rest badly. From where that puts it, the rest is within reach: again, as long as it brings
// more.
ResectedPhoto RematchFromPose(MatchingInput input, std::vector<GroundView> projected, const Relief& relief,
                              const std::vector<int>& neighbours, ResectedPhoto found) {
  const int photo = found.photo;
  MatchWindow window;
  window.radius_m = kMinRadiusShare * input.views[photo].WidthM();
  window.max_turn_rad = 0.45;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    input.views[photo].cam_from_enu = found.cam_from_enu;
    const std::vector<GroundKeypoint> keypoints =
        ProjectToGround(*input.features[photo], input.views[photo], relief);
    projected[photo].projected = &keypoints;
    std::optional<ResectedPhoto> again =
        Resect(input, projected, Collect(input, projected, relief, neighbours, photo, window), photo,
               std::numbers::pi * window.radius_m * window.radius_m);
    if (!again || MatchesOf(*again) <= MatchesOf(found)) break;
    found = *std::move(again);
  }
  return found;
}

}  // namespace

std::vector<ResectedPhoto> RegisterByResection(const MatchingInput& input, const Relief& relief,
                                               const std::vector<char>& is_aligned, double expected_error_m,
                                               int threads) {
  const std::size_t count = input.views.size();
  std::vector<int> lost;
  for (std::size_t i = 0; i < count; ++i) {
    if (!is_aligned[i] && input.features[i]) lost.push_back(static_cast<int>(i));
  }
  if (lost.empty() || lost.size() == count) return {};
  std::vector<Eigen::Vector2d> middles;
  for (const View& view : input.views) {
    Eigen::Vector3d middle = view.CenterInEnu();
    MeetGround(view, relief, {view.intrinsics.center_x_px, view.intrinsics.center_y_px}, &middle);
    middles.push_back(middle.head<2>());
  }
  const ProjectedKeypoints projected = ProjectAllToGround(input, relief, threads);
  std::vector<std::optional<ResectedPhoto>> found(lost.size());
  ParallelFor(lost.size(), threads, [&](std::size_t k) {
    const int photo = lost[k];
    const double width_m = input.views[photo].WidthM();
    const std::vector<int> neighbours = Neighbours(input, is_aligned, middles, photo);
    MatchWindow near, anywhere;
    near.radius_m = std::clamp(kExpectedErrors * expected_error_m, kMinRadiusShare * width_m, width_m);
    near.max_turn_rad = 0.8;
    anywhere.max_features = kFeaturesAnywhere;
    anywhere.max_distance_ratio = 0.8;
    const double near_area_m2 = std::numbers::pi * near.radius_m * near.radius_m;
    for (const auto& [window, area_m2] : {std::pair(near, near_area_m2), {anywhere, width_m * width_m}}) {
      if (found[k]) break;
      found[k] = Resect(input, projected.views,
                        Collect(input, projected.views, relief, neighbours, photo, window), photo, area_m2);
    }
    if (found[k])
      found[k] = RematchFromPose(input, projected.views, relief, neighbours, *std::move(found[k]));
  });
  std::vector<ResectedPhoto> resected;
  for (std::optional<ResectedPhoto>& one : found) {
    if (one) resected.push_back(std::move(*one));
  }
  return resected;
}

}  // namespace skyquilt::alignment
