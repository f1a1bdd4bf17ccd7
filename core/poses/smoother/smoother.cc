#include "core/poses/smoother/smoother.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/poses/smoother/chain_problem.h"
#include "core/poses/smoother/clean_input.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6x22 = Eigen::Matrix<double, 6, kStateSize>;

ChainGuess Moved(const ChainGuess& guess, const std::vector<Vector22>& step, double part) {
  ChainGuess moved = guess;
  for (std::size_t k = 0; k < guess.knots.size(); ++k) moved.knots[k] = guess.knots[k].Moved(-part * step[k]);
  if (step.size() > guess.knots.size()) moved.border.value -= part * step.back();
  return moved;
}

// The largest step in rotation (rad), velocity and position: what says that nothing moves any more.
bool IsSmall(const std::vector<Vector22>& step, std::size_t knots) {
  double largest = 0.0;
  for (std::size_t k = 0; k < knots; ++k) {
    largest = std::max(largest, step[k].segment<3>(kAtRotation).cwiseAbs().maxCoeff() / 1e-5);
    largest = std::max(largest, step[k].segment<3>(kAtVelocity).cwiseAbs().maxCoeff() / 1e-3);
    largest = std::max(largest, step[k].segment<3>(kAtPosition).cwiseAbs().maxCoeff() / 1e-3);
  }
  return largest < 1.0;
}

bool BiasesMovedFar(const ChainProblem& problem, const ChainGuess& guess) {
  for (int i = 0; i + 1 < problem.timeline().size(); ++i) {
    if (!problem.HasImu(i)) continue;
    const ImuDelta& d = problem.Imu(i).delta;
    const KnotState& k = guess.knots[Index(i)];
    if ((k.gyro_bias_radps - d.gyro_bias).norm() > 2e-3 || (k.accel_bias_mps2 - d.accel_bias).norm() > 0.1)
      return true;
  }
  return false;
}

// Gauss-Newton with step halving. Marquardt's damping stalls from a start that is kilometres off.
Result<void> Iterate(ChainProblem& problem, ChainGuess& guess, SmootherReport& report) {
  constexpr int kMaxIterations = 40;
  BlockSkyline matrix(problem.Outline(false));
  std::vector<Vector22> step;
  bool expanded_again = false;
  for (report.iterations = 0; report.iterations < kMaxIterations;) {
    ++report.iterations;
    const double cost = problem.Linearise(guess, matrix, step);
    if (!std::isfinite(cost) || !matrix.Factor()) {
      return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kSensorsContradict,
                             "normal equations are not positive definite");
    }
    matrix.Solve(step);
    double part = 1.0;
    ChainGuess next = Moved(guess, step, part);
    double next_cost = problem.Cost(next);
    while (!(next_cost <= cost) && part > 1e-3) {
      part *= 0.5;
      next = Moved(guess, step, part);
      next_cost = problem.Cost(next);
    }
    const bool fell = next_cost <= cost;
    if (fell) guess = std::move(next);
    if (fell && !IsSmall(step, guess.knots.size()) && cost - next_cost > 1e-6 * cost) continue;
    if (!expanded_again && BiasesMovedFar(problem, guess)) {
      expanded_again = true;
      problem.ExpandAbout(guess.knots);
      continue;
    }
    report.converged = fell || IsSmall(step, guess.knots.size()) || cost - next_cost > -1e-6 * cost;
    break;
  }
  return {};
}

Vector3d BodyRateAt(const ChainProblem& problem, const ChainGuess& guess, int knot) {
  const int last = problem.timeline().size() - 1;
  if (last == 0) return Vector3d::Zero();
  const int i = std::max(0, knot - 1);
  if (problem.HasImu(i))
    return problem.Imu(i).delta.end_rate_radps - guess.knots[Index(knot)].gyro_bias_radps;
  const int a = std::max(0, knot - 1);
  const int b = std::min(last, knot + 1);
  return LogSo3(guess.knots[Index(a)].enu_from_body.conjugate() * guess.knots[Index(b)].enu_from_body) /
         (problem.timeline().times()[Index(b)] - problem.timeline().times()[Index(a)]);
}

// The pose of one photo from its knot and the border, with its derivatives by both.
struct PhotoPose {
  SmoothedPose pose;
  Matrix6x22 by_knot = Matrix6x22::Zero();
  Matrix6x22 by_border = Matrix6x22::Zero();
};

PhotoPose PoseOfPhoto(const ChainProblem& problem, const ChainGuess& guess, int photo) {
  const int k = problem.PhotoKnot(photo);
  const KnotState& s = guess.knots[Index(k)];
  const BorderState& border = guess.border;
  const double tau = border.TauCamera();
  const Vector3d rate = BodyRateAt(problem, guess, k);
  const Matrix3d r = s.enu_from_body.toRotationMatrix();
  PhotoPose out;
  out.pose.t_s = problem.input().photo_times_s[Index(photo)];
  const Eigen::Quaterniond at_exposure = s.enu_from_body * geo::RotationFromVector(tau * rate);
  out.pose.enu_from_body = (at_exposure * geo::RotationFromVector(border.Boresight())).normalized();
  out.pose.velocity_in_enu_mps = s.velocity_in_enu_mps;
  out.pose.position_in_enu_m = s.position_in_enu_m + tau * s.velocity_in_enu_mps;
  out.pose.attitude_bias_rad = s.attitude_bias_rad;
  out.by_knot.block<3, 3>(0, kAtRotation) = r;
  out.by_knot.block<3, 3>(3, kAtPosition).setIdentity();
  out.by_knot.block<3, 3>(3, kAtVelocity) = tau * Matrix3d::Identity();
  out.by_border.block<3, 1>(0, kAtTauCamera) = r * rate;
  out.by_border.block<3, 3>(0, kAtBoresight) = r;
  out.by_border.block<3, 1>(3, kAtTauCamera) = s.velocity_in_enu_mps;
  for (int i = 0; i < kStateSize; ++i) {
    if (!(problem.border_sigma()(i) > 0.0)) out.by_border.col(i).setZero();
  }
  return out;
}

// Covariance between two photos (of knots ka >= kb or one and the same) with the border's share.
Matrix6d CrossCovariance(const BlockSkyline& inverse, const ChainProblem& problem, const PhotoPose& a, int ka,
                         const PhotoPose& b, int kb) {
  const Matrix22 between = ka >= kb ? Matrix22(inverse.At(ka, kb)) : Matrix22(inverse.At(kb, ka).transpose());
  Matrix6d c = a.by_knot * between * b.by_knot.transpose();
  if (!problem.HasBorder()) return c;
  const int border = problem.timeline().size();
  c.noalias() += a.by_border * inverse.At(border, kb) * b.by_knot.transpose();
  c.noalias() += a.by_knot * inverse.At(border, ka).transpose() * b.by_border.transpose();
  c.noalias() += a.by_border * inverse.At(border, border) * b.by_border.transpose();
  return c;
}

void FillPoses(const ChainProblem& problem, const ChainGuess& guess, const BlockSkyline& inverse,
               SmootherOutput& output) {
  const int photos = static_cast<int>(problem.input().photo_times_s.size());
  std::vector<PhotoPose> made;
  made.reserve(Index(photos));
  for (int i = 0; i < photos; ++i) made.push_back(PoseOfPhoto(problem, guess, i));
  for (int i = 0; i < photos; ++i) {
    PhotoPose& here = made[Index(i)];
    const int k = problem.PhotoKnot(i);
    const Matrix6d own = CrossCovariance(inverse, problem, here, k, here, k);
    here.pose.covariance = 0.5 * (own + own.transpose());
    if (i + 1 < photos) {
      here.pose.covariance_with_next =
          CrossCovariance(inverse, problem, here, k, made[Index(i) + 1], problem.PhotoKnot(i + 1));
    }
    output.poses.push_back(here.pose);
  }
  if (!problem.HasBorder()) return;
  const Matrix22& border = inverse.At(problem.timeline().size(), problem.timeline().size());
  for (int i = 0; i < kBorderUsed; ++i) {
    if (problem.border_sigma()(i) > 0.0) output.border_sigma(i) = std::sqrt(std::max(0.0, border(i, i)));
  }
}

// Between knots the motion is a prior's guess: velocities that come faster than knots would be blurred by it.
double KnotSpacingS(const SmootherInput& input) {
  constexpr double kWithImuS = 0.5, kSlowS = 1.0;
  if (!input.imu.empty()) return kWithImuS;
  if (input.velocities.size() < 2) return kSlowS;
  const double step_s = (input.velocities.back().t_s - input.velocities.front().t_s) /
                        static_cast<double>(input.velocities.size() - 1);
  return step_s < 0.5 * kSlowS ? std::max(0.2, step_s) : kSlowS;
}

// Free memory is the caller's, but a chain longer than any flight is a mistake in the times.
constexpr int kMaxKnots = 200000;

}  // namespace

Result<SmootherOutput> SmoothChain(const SmootherInput& raw) {
  SmootherOutput output;
  Result<CleanInput> clean = CleanSmootherInput(raw);
  if (!clean.ok()) return clean.error();
  SmootherInput& input = clean->input;
  output.report.warnings = clean->warnings;
  const double spacing = KnotSpacingS(input);
  if ((clean->end_s - clean->begin_s) / spacing + static_cast<double>(input.photo_times_s.size()) >
      kMaxKnots) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kMoreThanADay);
  }
  if (input.imu.empty() && input.positions.empty()) {
    // Only the photos' motions say how far the flight went: a prior against acceleration would shrink it.
    input.options.acceleration_density = std::max(input.options.acceleration_density, 25.0);
  }
  ChainTimeline timeline(clean->begin_s, clean->end_s, input.photo_times_s, spacing);
  if (input.imu.empty()) input.attitudes = AttitudesAtKnots(input.attitudes, timeline.times());
  ChainProblem problem(input, std::move(timeline));
  ChainGuess guess = GuessChain(problem);
  if (Result<void> done = Iterate(problem, guess, output.report); !done.ok()) return done.error();

  BlockSkyline matrix(problem.Outline(true));
  std::vector<Vector22> gradient;
  problem.Linearise(guess, matrix, gradient);
  if (!matrix.Factor()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kTrackNotFixed,
                           "normal equations at the solution are not positive definite");
  }
  matrix.SelectedInverse();
  FillPoses(problem, guess, matrix, output);
  problem.Cost(guess, &output.report);
  output.report.knots = problem.timeline().size();
  if (!output.report.converged)
    output.report.warnings.push_back("The smoother stopped before it had settled.");
  output.border = guess.border;
  return output;
}

}  // namespace skyquilt::poses
