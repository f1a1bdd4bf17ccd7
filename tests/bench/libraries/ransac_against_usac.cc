// Our robust estimators beside OpenCV's USAC, on made pairs with a known share of right ones (noise of one
// pixel, the others anywhere): homographies by RobustHomography (core/alignment/estimators), two views of
// ground in relief by VerifyTwoViews (core/alignment/estimators). Both get 300 pairs in photos of 4000 x 3000
// pixels.
//   ransac_against_usac [PROBLEMS a share]
// Deterministic but for the times, which are processor time of one thread.
#include <fmt/core.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <string>

#include "core/alignment/estimators/epipolar.h"
#include "core/alignment/estimators/two_view.h"
#include "core/alignment/scene/matches.h"
#include "core/base/median.h"
#include "core/geo/rigid3.h"
#include "tests/bench/libraries/measure.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kPairs = 300, kWidthPx = 4000, kHeightPx = 3000;
constexpr double kFocalPx = 3000.0, kHeightM = 50.0, kSigmaPx = 1.0;
constexpr double kDegree = std::numbers::pi / 180.0;

struct Problem {
  geo::Rigid3 second_from_first;
  std::optional<Matrix3d> homography;  // where the ground is flat
  PhotoFeatures first, second;
  std::vector<KeypointMatch> matches;
  std::vector<cv::Point2f> from, to;
};

// Two cameras that look down from 50 m, up to a sixth of that apart in any way, turned any way and tilted by
// up to 8 degrees each.
Problem MakeProblem(double right_share, double relief_m, std::uint64_t seed) {
  Sampler sampler(seed);
  const auto between = [&](double low, double high) { return low + (high - low) * Uniform(sampler); };
  const auto tilted = [&](double yaw) {
    return geo::RotationFromVector({between(-8.0, 8.0) * kDegree, between(-8.0, 8.0) * kDegree, 0.0}) *
           geo::RotationFromVector({0.0, 0.0, yaw});
  };
  const geo::Rigid3 first{
      tilted(0.0), Vector3d::Zero()};  // cam_from_level, level being x right, y down, z into the ground
  const double way = between(-std::numbers::pi, std::numbers::pi), far_m = between(8.0, 18.0);
  const geo::Rigid3 second = geo::Rigid3::FromRotationAndTargetOrigin(
      tilted(between(-std::numbers::pi, std::numbers::pi)),
      {far_m * std::cos(way), far_m * std::sin(way), between(-4.0, 4.0)});
  Problem problem;
  problem.second_from_first = second * first.Inverse();
  const camera::Intrinsics lens = camera::Intrinsics::Centered(kWidthPx, kHeightPx, kFocalPx);
  if (relief_m == 0.0) {
    const Vector3d normal = first.rotation * Vector3d::UnitZ() / kHeightM;  // n . x = 1 on the ground
    problem.homography = lens.K() *
                         (problem.second_from_first.rotation.toRotationMatrix() +
                          problem.second_from_first.translation * normal.transpose()) *
                         lens.K().inverse();
  }
  const double turn = std::atan2(problem.second_from_first.rotation.toRotationMatrix()(1, 0),
                                 problem.second_from_first.rotation.toRotationMatrix()(0, 0));
  problem.first.sigma_px = problem.second.sigma_px = kSigmaPx;
  while (static_cast<int>(problem.matches.size()) < kPairs) {
    const Vector3d ground(between(-45.0, 45.0), between(-40.0, 40.0), kHeightM - between(0.0, relief_m));
    const auto seen = lens.Project(first * ground), seen_again = lens.Project(second * ground);
    if (!seen || !seen_again || !lens.IsInImage(*seen) || !lens.IsInImage(*seen_again)) continue;
    const bool is_right = Uniform(sampler) < right_share;
    const auto shaken = [&](const Vector2d& pixel) -> Vector2d {
      return pixel + kSigmaPx * Vector2d(Gaussian(sampler), Gaussian(sampler));
    };
    const Vector2d at = shaken(*seen);
    const Vector2d there =
        is_right ? shaken(*seen_again) : Vector2d(between(0.0, kWidthPx), between(0.0, kHeightPx));
    const int k = static_cast<int>(problem.matches.size());
    problem.matches.push_back({k, k});
    const double angle = between(-std::numbers::pi, std::numbers::pi);
    const double turned =
        is_right ? angle + turn + 0.1 * Gaussian(sampler) : between(-std::numbers::pi, std::numbers::pi);
    const double grown = std::exp2(is_right ? 0.1 * Gaussian(sampler) : Gaussian(sampler));
    problem.first.keypoints.push_back(
        {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(angle), 10.0F});
    problem.second.keypoints.push_back({static_cast<float>(there.x()), static_cast<float>(there.y()),
                                        static_cast<float>(turned), static_cast<float>(10.0 * grown)});
    problem.from.emplace_back(problem.first.keypoints.back().x_px, problem.first.keypoints.back().y_px);
    problem.to.emplace_back(problem.second.keypoints.back().x_px, problem.second.keypoints.back().y_px);
  }
  return problem;
}

Matrix3d FromCv(const cv::Mat& mat) {
  Matrix3d matrix;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) matrix(r, c) = mat.at<double>(r, c);
  }
  return matrix;
}

struct Outcome {
  double error = 0.0;  // pixels of a homography's CE90, degrees of a pose's rotation
  double way_deg = 0.0;
};
using Solver = std::function<std::optional<Outcome>(const Problem&)>;

// Worst of the places that both photos show, nine of ten.
Outcome JudgeHomography(const Problem& problem, const Matrix3d& found) {
  std::vector<double> errors;
  for (int y = 0; y <= 8; ++y) {
    for (int x = 0; x <= 8; ++x) {
      const Vector3d at(x * kWidthPx / 8.0, y * kHeightPx / 8.0, 1.0);
      const Vector2d truth = (*problem.homography * at).hnormalized();
      if (truth.x() < 0 || truth.y() < 0 || truth.x() > kWidthPx || truth.y() > kHeightPx) continue;
      errors.push_back(((found * at).hnormalized() - truth).norm());
    }
  }
  return {errors.empty() ? 0.0 : Quantile(errors, 0.9), 0.0};
}

Outcome JudgePose(const Problem& problem, const Eigen::Quaterniond& rotation, const Vector3d& direction) {
  const Vector3d truth = problem.second_from_first.translation.normalized();
  return {rotation.angularDistance(problem.second_from_first.rotation) / kDegree,
          std::acos(std::min(1.0, truth.dot(direction.normalized()))) / kDegree};
}

Solver OurHomography() {
  return [](const Problem& problem) -> std::optional<Outcome> {
    std::vector<RayPair> pairs;
    for (std::size_t k = 0; k < problem.from.size(); ++k) {
      pairs.push_back({{problem.from[k].x, problem.from[k].y}, {problem.to[k].x, problem.to[k].y}});
    }
    const std::optional<RobustFit> fit = RobustHomography(pairs, 4.0);
    if (!fit) return std::nullopt;
    return JudgeHomography(problem, fit->second_from_first);
  };
}

Solver CvHomography(int method) {
  return [method](const Problem& problem) -> std::optional<Outcome> {
    const cv::Mat found =
        cv::findHomography(problem.from, problem.to, method, 4.0, cv::noArray(), 1000, 0.999);
    if (found.empty()) return std::nullopt;
    return JudgeHomography(problem, FromCv(found));
  };
}

Solver OurTwoViews() {
  return [](const Problem& problem) -> std::optional<Outcome> {
    const camera::Intrinsics lens = camera::Intrinsics::Centered(kWidthPx, kHeightPx, kFocalPx);
    Registration input;
    input.lenses.emplace_back().intrinsics = lens;
    for (const PhotoFeatures* features : {&problem.first, &problem.second}) input.Add(features, 0, {});
    const auto view = VerifyTwoViews(input, RaysOf(input, kPairs, 1), {0, 1, {}, problem.matches}, 3.0);
    if (!view || view->poses.front().translation.squaredNorm() < 0.5) return std::nullopt;
    Outcome best = JudgePose(problem, view->poses.front().rotation, view->poses.front().translation);
    if (problem.homography && view->poses.size() > 1) {  // flat ground leaves two
      const Outcome other = JudgePose(problem, view->poses[1].rotation, view->poses[1].translation);
      if (other.error + other.way_deg < best.error + best.way_deg) best = other;
    }
    return best;
  };
}

Solver CvTwoViews(int method) {
  return [method](const Problem& problem) -> std::optional<Outcome> {
    const camera::Intrinsics lens = camera::Intrinsics::Centered(kWidthPx, kHeightPx, kFocalPx);
    const cv::Matx33d k(lens.focal_x_px, 0.0, lens.center_x_px, 0.0, lens.focal_y_px, lens.center_y_px, 0.0,
                        0.0, 1.0);
    cv::Mat used, rotation, shift;
    cv::Mat essential = cv::findEssentialMat(problem.from, problem.to, k, method, 0.999, 3.0, used);
    if (essential.rows != 3) return std::nullopt;
    if (cv::recoverPose(essential, problem.from, problem.to, k, rotation, shift, used) < 8)
      return std::nullopt;
    return JudgePose(problem, Eigen::Quaterniond(FromCv(rotation)),
                     {shift.at<double>(0), shift.at<double>(1), shift.at<double>(2)});
  };
}

// The best of the up to four poses that a homography stands for.
Solver CvFlatViews(int method) {
  return [method](const Problem& problem) -> std::optional<Outcome> {
    const camera::Intrinsics lens = camera::Intrinsics::Centered(kWidthPx, kHeightPx, kFocalPx);
    const cv::Matx33d k(lens.focal_x_px, 0.0, lens.center_x_px, 0.0, lens.focal_y_px, lens.center_y_px, 0.0,
                        0.0, 1.0);
    const cv::Mat found =
        cv::findHomography(problem.from, problem.to, method, 4.0, cv::noArray(), 1000, 0.999);
    if (found.empty()) return std::nullopt;
    std::vector<cv::Mat> rotations, shifts, normals;
    cv::decomposeHomographyMat(found, k, rotations, shifts, normals);
    std::optional<Outcome> best;
    for (std::size_t n = 0; n < rotations.size(); ++n) {
      const Outcome outcome =
          JudgePose(problem, Eigen::Quaterniond(FromCv(rotations[n])),
                    {shifts[n].at<double>(0), shifts[n].at<double>(1), shifts[n].at<double>(2)});
      if (!best || outcome.error + outcome.way_deg < best->error + best->way_deg) best = outcome;
    }
    return best;
  };
}

struct Named {
  std::string name;
  Solver solve;
};

void Compare(const std::string& title, const std::vector<Named>& solvers, double relief_m, int problems,
             const std::function<bool(const Outcome&)>& is_right) {
  fmt::print("\n{}\n{:>6}", title, "right");
  for (const Named& solver : solvers) fmt::print(" | {:^29}", solver.name);
  fmt::print("\n{:>6}", "pairs");
  for (std::size_t s = 0; s < solvers.size(); ++s)
    fmt::print(" | {:>8} {:>10} {:>9}", "ms", "error", "succeeds");
  fmt::print("\n");
  for (int percent = 20; percent <= 90; percent += 10) {
    fmt::print("{:5}%", percent);
    std::vector<Problem> made;
    for (int k = 0; k < problems; ++k) {
      made.push_back(MakeProblem(percent / 100.0, relief_m, static_cast<std::uint64_t>(1000 * percent + k)));
    }
    for (const Named& solver : solvers) {
      std::vector<double> seconds, errors;
      for (const Problem& problem : made) {
        const double start = ThreadSeconds();
        const std::optional<Outcome> outcome = solver.solve(problem);
        seconds.push_back(ThreadSeconds() - start);
        if (outcome && is_right(*outcome)) errors.push_back(outcome->error);
      }
      const double share = 100.0 * static_cast<double>(errors.size()) / problems;
      fmt::print(" | {:8.2f} {:10.3f} {:8.0f}%", 1e3 * Median(seconds), MedianIfAny(errors).value_or(0.0),
                 share);
    }
    fmt::print("\n");
  }
}

}  // namespace
}  // namespace skyquilt::alignment

int main(int argc, char** argv) {
  using namespace skyquilt::alignment;
  cv::setNumThreads(1);
  const int problems = argc > 1 ? std::atoi(argv[1]) : 40;
  fmt::print("Median milliseconds; median error where it succeeds.\n");
  Compare("Homography of flat ground: CE90 in pixels over what both show; succeeds below 5",
          {{"ours", OurHomography()},
           {"cv RANSAC", CvHomography(cv::RANSAC)},
           {"cv USAC_DEFAULT", CvHomography(cv::USAC_DEFAULT)},
           {"cv USAC_MAGSAC", CvHomography(cv::USAC_MAGSAC)}},
          0.0, problems, [](const Outcome& outcome) { return outcome.error < 5.0; });
  Compare(
      "Two views of flat ground, the best of the poses it leaves open: rotation in degrees; succeeds below 1, the way within 10",
      {{"ours", OurTwoViews()},
       {"cv RANSAC", CvFlatViews(cv::RANSAC)},
       {"cv USAC_DEFAULT", CvFlatViews(cv::USAC_DEFAULT)},
       {"cv USAC_MAGSAC", CvFlatViews(cv::USAC_MAGSAC)}},
      0.0, problems, [](const Outcome& outcome) { return outcome.error < 1.0 && outcome.way_deg < 10.0; });
  Compare("Two views of ground with 8 m of relief: rotation in degrees; succeeds below 1, the way within 10",
          {{"ours", OurTwoViews()},
           {"cv RANSAC", CvTwoViews(cv::RANSAC)},
           {"cv USAC_DEFAULT", CvTwoViews(cv::USAC_DEFAULT)},
           {"cv USAC_MAGSAC", CvTwoViews(cv::USAC_MAGSAC)}},
          8.0, problems,
          [](const Outcome& outcome) { return outcome.error < 1.0 && outcome.way_deg < 10.0; });
  return 0;
}
