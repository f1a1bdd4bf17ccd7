// Our resection (core/alignment/estimators/absolute_pose) beside libraries: its three points beside
// cv::solveP3P, its refinement beside Ceres with the same robust loss, and the whole beside
// cv::solvePnPRansac. A camera 50 m above ground with 8 m of relief, a lens with distortion, sights with
// noise of one pixel.
//   resection_against_ceres [PROBLEMS]
// Deterministic but for the times, which are processor time of one thread.
#include <ceres/ceres.h>
#include <fmt/core.h>

#include <Eigen/Dense>
#include <array>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <string>

#include "core/alignment/estimators/absolute_pose.h"
#include "core/base/median.h"
#include "tests/bench/libraries/measure.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kHeightM = 50.0, kDegree = std::numbers::pi / 180.0;

camera::Intrinsics Lens() {
  camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  lens.k1 = -0.08, lens.k2 = 0.02, lens.p1 = 0.0004;
  return lens;
}

struct Problem {
  geo::Rigid3 truth;
  std::vector<PointObservation> observations;
};

double Between(Sampler& sampler, double low, double high) { return low + (high - low) * Uniform(sampler); }

Vector3d AnyWay(Sampler& sampler) {
  return Vector3d(Gaussian(sampler), Gaussian(sampler), Gaussian(sampler)).normalized();
}

Problem MakeProblem(int count, double right_share, std::uint64_t seed) {
  const camera::Intrinsics lens = Lens();
  Sampler sampler(seed);
  const Eigen::Quaterniond rotation = geo::RotationFromVector(0.2 * Uniform(sampler) * AnyWay(sampler)) *
                                      geo::RotationFromVector({0.0, 0.0, Between(sampler, -3.0, 3.0)}) *
                                      geo::RotationFromVector({std::numbers::pi, 0.0, 0.0});
  Problem problem{geo::Rigid3::FromRotationAndTargetOrigin(rotation, {0.0, 0.0, kHeightM}), {}};
  while (static_cast<int>(problem.observations.size()) < count) {
    const Vector3d point(Between(sampler, -45.0, 45.0), Between(sampler, -45.0, 45.0),
                         Between(sampler, 0.0, 8.0));
    const auto pixel = lens.Project(problem.truth * point);
    if (!pixel || !lens.IsInImage(*pixel)) continue;
    PointObservation seen{*pixel + Vector2d(Gaussian(sampler), Gaussian(sampler)), point, 1.0};
    if (Uniform(sampler) >= right_share)
      seen.pixel_in_image = {4000.0 * Uniform(sampler), 3000.0 * Uniform(sampler)};
    problem.observations.push_back(seen);
  }
  return problem;
}

double CenterErrorM(const Problem& problem, const geo::Rigid3& pose) {
  return (pose.TargetOriginInSource() - problem.truth.TargetOriginInSource()).norm();
}

// The residual of RefineResection with derivatives by Ceres.
struct Sight {
  camera::Intrinsics lens;
  PointObservation seen;

  template <typename T>
  bool operator()(const T* turn, const T* shift, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(turn);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> translation(shift);
    const Eigen::Matrix<T, 3, 1> in_cam = rotation * seen.point_in_world.cast<T>() + translation;
    if (in_cam.z() <= T(0.0)) {  // behind the camera: as bad as can be, and no way out of it
      residual[0] = residual[1] = T(1e6);
      return true;
    }
    const T x = in_cam.x() / in_cam.z(), y = in_cam.y() / in_cam.z(), r2 = x * x + y * y;
    const T radial = T(1.0) + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
    const T bent_x = x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x);
    const T bent_y = y * radial + lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y;
    residual[0] = (lens.focal_x_px * bent_x + lens.center_x_px - seen.pixel_in_image.x()) / seen.sigma_px;
    residual[1] = (lens.focal_y_px * bent_y + lens.center_y_px - seen.pixel_in_image.y()) / seen.sigma_px;
    return true;
  }
};

geo::Rigid3 RefineByCeres(const geo::Rigid3& start, const std::vector<PointObservation>& observations,
                          int max_steps) {
  geo::Rigid3 pose = start;
  ceres::Problem problem;
  problem.AddParameterBlock(pose.rotation.coeffs().data(), 4, new ceres::EigenQuaternionManifold);
  for (const PointObservation& seen : observations) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Sight, 2, 4, 3>(new Sight{Lens(), seen}),
                             new ceres::CauchyLoss(2.5), pose.rotation.coeffs().data(),
                             pose.translation.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = max_steps;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  pose.rotation.normalize();
  return pose;
}

geo::Rigid3 PoseOfCv(const cv::Mat& turn, const cv::Mat& shift) {
  const Vector3d by(turn.at<double>(0), turn.at<double>(1), turn.at<double>(2));
  return {geo::RotationFromVector(by), {shift.at<double>(0), shift.at<double>(1), shift.at<double>(2)}};
}

struct ForCv {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  cv::Matx33d k;
  std::vector<double> distortion;

  explicit ForCv(const std::vector<PointObservation>& observations) {
    const camera::Intrinsics lens = Lens();
    k = {lens.focal_x_px, 0.0, lens.center_x_px, 0.0, lens.focal_y_px, lens.center_y_px, 0.0, 0.0, 1.0};
    distortion = {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3};
    for (const PointObservation& seen : observations) {
      points.emplace_back(seen.point_in_world.x(), seen.point_in_world.y(), seen.point_in_world.z());
      pixels.emplace_back(seen.pixel_in_image.x(), seen.pixel_in_image.y());
    }
  }
};

// One line: median time, median error of the camera's place where it came near the truth, how often it did.
void Report(const std::string& name, const std::vector<double>& seconds, const std::vector<double>& errors_m,
            double near_m) {
  std::vector<double> near;
  for (const double error : errors_m) {
    if (error < near_m) near.push_back(error);
  }
  const double share = 100.0 * static_cast<double>(near.size()) / static_cast<double>(errors_m.size());
  fmt::print("  {:34} {:9.1f} us   {:9.2e} m   {:5.1f} %\n", name, 1e6 * Median(seconds),
             MedianIfAny(near).value_or(0.0), share);
}

using Solver = std::function<std::optional<geo::Rigid3>(const Problem&, const geo::Rigid3& start)>;

void Compare(const std::vector<std::pair<std::string, Solver>>& solvers, const std::vector<Problem>& problems,
             double turn_deg, double shift_m, double near_m) {
  for (const auto& [name, solve] : solvers) {
    std::vector<double> seconds, errors_m;
    Sampler sampler(5);
    for (const Problem& problem : problems) {
      const geo::Rigid3 start = geo::Rigid3::FromRotationAndTargetOrigin(
          geo::RotationFromVector(turn_deg * kDegree * AnyWay(sampler)) * problem.truth.rotation,
          problem.truth.TargetOriginInSource() + shift_m * AnyWay(sampler));
      const double begun = ThreadSeconds();
      const std::optional<geo::Rigid3> pose = solve(problem, start);
      seconds.push_back(ThreadSeconds() - begun);
      errors_m.push_back(pose ? CenterErrorM(problem, *pose) : std::numeric_limits<double>::infinity());
    }
    Report(name, seconds, errors_m, near_m);
  }
}

// Of its up to four poses the one nearest to the truth.
std::optional<geo::Rigid3> OurThree(const Problem& problem) {
  const camera::Intrinsics lens = Lens();
  std::array<Vector3d, 3> rays, points;
  for (std::size_t k = 0; k < 3; ++k) {
    rays[k] = lens.Unproject(problem.observations[k].pixel_in_image).normalized();
    points[k] = problem.observations[k].point_in_world;
  }
  std::optional<geo::Rigid3> best;
  for (const geo::Rigid3& pose : PosesOfThree(rays, points)) {
    if (!best || CenterErrorM(problem, pose) < CenterErrorM(problem, *best)) best = pose;
  }
  return best;
}

std::optional<geo::Rigid3> CvThree(const Problem& problem, int method) {
  const ForCv given({problem.observations.begin(), problem.observations.begin() + 3});
  std::vector<cv::Mat> turns, shifts;
  cv::solveP3P(given.points, given.pixels, given.k, given.distortion, turns, shifts, method);
  std::optional<geo::Rigid3> best;
  for (std::size_t k = 0; k < turns.size(); ++k) {
    const geo::Rigid3 pose = PoseOfCv(turns[k], shifts[k]);
    if (!best || CenterErrorM(problem, pose) < CenterErrorM(problem, *best)) best = pose;
  }
  return best;
}

std::optional<geo::Rigid3> CvRansac(const Problem& problem, int method, bool refined) {
  const ForCv given(problem.observations);
  cv::Mat turn, shift;
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(given.points, given.pixels, given.k, given.distortion, turn, shift, false, 200,
                          8.0F, 0.9999, inliers, method) ||
      inliers.size() < 12) {
    return std::nullopt;
  }
  if (refined) {
    std::vector<PointObservation> used;
    for (const int k : inliers) used.push_back(problem.observations[static_cast<std::size_t>(k)]);
    const ForCv again(used);
    cv::solvePnPRefineLM(again.points, again.pixels, again.k, again.distortion, turn, shift);
  }
  return PoseOfCv(turn, shift);
}

std::vector<Problem> MakeProblems(int problems, int count, double right_share) {
  std::vector<Problem> made;
  for (int k = 0; k < problems; ++k)
    made.push_back(MakeProblem(count, right_share, static_cast<std::uint64_t>(k + 1)));
  return made;
}

std::optional<geo::Rigid3> OurRefinement(const Problem& problem, const geo::Rigid3& start) {
  std::vector<int> all(problem.observations.size());
  std::iota(all.begin(), all.end(), 0);
  return RefineResection(Lens(), start, problem.observations, all);
}

void CompareRefinements(int count) {
  const auto ceres_of = [](int max_steps) -> Solver {
    return [max_steps](const Problem& problem, const geo::Rigid3& start) {
      return RefineByCeres(start, problem.observations, max_steps);
    };
  };
  struct Start {
    double turn_deg, shift_m, right_share;
  };
  for (const Start& start : {Start{0.2, 0.2, 1.0}, Start{3.0, 3.0, 0.9}, Start{10.0, 10.0, 0.9},
                             Start{20.0, 15.0, 0.9}, Start{40.0, 25.0, 1.0}, Start{60.0, 30.0, 1.0}}) {
    fmt::print("Refinement of 200 sights, {:.0f} % right, from {} degrees and {} m away; near: below 0.2 m\n",
               100.0 * start.right_share, start.turn_deg, start.shift_m);
    Compare({{"ours, at most 10 steps", OurRefinement},
             {"Ceres, at most 10 steps", ceres_of(10)},
             {"Ceres, at most 50 steps", ceres_of(50)}},
            MakeProblems(count, 200, start.right_share), start.turn_deg, start.shift_m, 0.2);
  }
}

void CompareWhole(int count) {
  for (const double right_share : {0.2, 0.35, 0.5, 0.7, 0.9}) {
    fmt::print("Pose from 200 sights, {:.0f} % right; near: below 0.2 m\n", 100.0 * right_share);
    const auto cv_by = [](int method, bool refined) -> Solver {
      return [=](const Problem& problem, const geo::Rigid3&) { return CvRansac(problem, method, refined); };
    };
    Compare({{"ours (FindPose)",
              [](const Problem& problem, const geo::Rigid3&) -> std::optional<geo::Rigid3> {
                const auto found = FindPose(Lens(), problem.observations, 1, {});
                if (!found) return std::nullopt;
                return found->cam_from_world;
              }},
             {"cv::solvePnPRansac, P3P", cv_by(cv::SOLVEPNP_P3P, false)},
             {"cv::solvePnPRansac, P3P, refineLM", cv_by(cv::SOLVEPNP_P3P, true)},
             {"cv::solvePnPRansac, SQPNP, refineLM", cv_by(cv::SOLVEPNP_SQPNP, true)}},
            MakeProblems(count, 200, right_share), 0.0, 0.0, 0.2);
  }
}

}  // namespace
}  // namespace skyquilt::alignment

int main(int argc, char** argv) {
  using namespace skyquilt::alignment;
  cv::setNumThreads(1);
  const int count = argc > 1 ? std::atoi(argv[1]) : 100;
  fmt::print("Median time; median error of the camera's place where it came near; how often it did.\n");
  fmt::print("Three sights, the best of up to four poses; near: below 2 m\n");
  Compare({{"ours (PosesOfThree)", [](const Problem& problem, const auto&) { return OurThree(problem); }},
           {"cv::solveP3P, P3P",
            [](const Problem& problem, const auto&) { return CvThree(problem, cv::SOLVEPNP_P3P); }},
           {"cv::solveP3P, AP3P",
            [](const Problem& problem, const auto&) { return CvThree(problem, cv::SOLVEPNP_AP3P); }}},
          MakeProblems(10 * count, 3, 1.0), 0.0, 0.0, 2.0);
  CompareRefinements(count);
  CompareWhole(count);
  return 0;
}
