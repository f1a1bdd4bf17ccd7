#include "core/poses/smoother/smoother.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/poses/log_span.h"
#include "core/poses/smoother/chain_problem.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6x22 = Eigen::Matrix<double, 6, kStateSize>;

bool IsGood(const flight::ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite();
}
bool IsGood(const PositionFix& f) {
  return f.position_in_enu_m.allFinite() && f.sigma_m.allFinite() && f.sigma_m.minCoeff() > 0.0;
}
bool IsGood(const VelocityFix& f) {
  return f.velocity_in_enu_mps.allFinite() && f.sigma_mps.allFinite() && f.sigma_mps.minCoeff() > 0.0;
}
bool IsGood(const AttitudeFix& f) {
  return f.enu_from_body.coeffs().allFinite() && std::abs(f.enu_from_body.norm() - 1.0) < 1e-3 &&
         std::isfinite(f.sigma_rad) && f.sigma_rad > 0.0;
}
bool IsGood(const HeightFix& f) {
  return std::isfinite(f.z_in_enu_m) && std::isfinite(f.sigma_m) && f.sigma_m > 0.0;
}
bool IsGood(const RangeFix& f) { return std::isfinite(f.distance_m) && f.distance_m > 0.0; }
bool IsGood(const Marker& m) {
  return m.position_in_enu_m.allFinite() && std::isfinite(m.sigma_m) && m.sigma_m > 0.0 &&
         (!m.yaw_rad || (std::isfinite(*m.yaw_rad) && m.sigma_yaw_rad > 0.0));
}

// Keeps what is finite and later than all kept before it. Times that run back for one sample lose that
// sample; `may_repeat` is for markers.
template <typename Fix>
void Clean(const char* name, bool may_repeat, std::vector<Fix>& fixes, std::vector<std::string>& warnings) {
  std::vector<Fix> kept;
  kept.reserve(fixes.size());
  for (const Fix& f : fixes) {
    if (!std::isfinite(f.t_s) || !IsGood(f)) continue;
    if (!kept.empty() && !(may_repeat ? f.t_s >= kept.back().t_s : f.t_s > kept.back().t_s)) continue;
    kept.push_back(f);
  }
  if (kept.size() < fixes.size()) {
    warnings.push_back(std::to_string(fixes.size() - kept.size()) + " of " + std::to_string(fixes.size()) +
                       " " + name + " samples were left out: not finite, repeated or out of order.");
  }
  fixes = std::move(kept);
}

template <typename Fix>
void Cut(double begin, double end, std::vector<Fix>& fixes) {
  std::erase_if(fixes, [&](const Fix& f) { return f.t_s < begin || f.t_s > end; });
}

constexpr double kMarginS = 30.0;       // measurements this long before and after the photos still help
constexpr double kRestMarginS = 120.0;  // stillness fixes the speed and the biases from further off

// What the smoother may rely on: every series finite, in rising order, without repeats, and cut to the part
// of the flight that the photos need.
struct CleanInput {
  SmootherInput input;
  // The chain's span: photos, markers and stillness, and half a minute more where data is.
  double begin_s = 0.0, end_s = 0.0;
  std::vector<std::string> warnings;
};

// Fails without photos, with photo times that do not rise or are not finite, and where nothing at all says
// where the flight was.
Result<CleanInput> CleanSmootherInput(const SmootherInput& raw) {
  CleanInput clean;
  clean.input = raw;
  SmootherInput& in = clean.input;
  if (in.photo_times_s.empty())
    return Error{ErrorCode::kUnprocessable, "There are no photos to find poses for.", ""};
  for (std::size_t k = 0; k < in.photo_times_s.size(); ++k) {
    if (!std::isfinite(in.photo_times_s[k]) || (k > 0 && in.photo_times_s[k] < in.photo_times_s[k - 1])) {
      return Error{ErrorCode::kUnprocessable, "The times of the photos are not known or not in order.",
                   "photo " + std::to_string(k)};
    }
  }
  Clean("inertial", false, in.imu, clean.warnings);
  Clean("position", false, in.positions, clean.warnings);
  Clean("velocity", false, in.velocities, clean.warnings);
  Clean("attitude", false, in.attitudes, clean.warnings);
  Clean("height", false, in.heights, clean.warnings);
  Clean("range", false, in.ranges, clean.warnings);
  Clean("marker", true, in.markers, clean.warnings);

  LogSpan asked{in.photo_times_s.front(), in.photo_times_s.back()};
  asked.Take(in.markers);
  for (const StillInterval& s : in.still) {
    // Stillness long before or after the flight, with no marker in it, has nothing to say.
    if (s.end_s < asked.begin_s - kRestMarginS || s.begin_s > asked.end_s + kRestMarginS) continue;
    asked.Take(s.begin_s);
    asked.Take(s.end_s);
  }
  LogSpan known;
  known.Take(in.imu);
  known.Take(in.positions);
  known.Take(in.velocities);
  known.Take(in.attitudes);
  known.Take(in.heights);
  clean.begin_s = std::min(asked.begin_s, std::max(known.begin_s, asked.begin_s - kMarginS));
  clean.end_s = std::max(asked.end_s, std::min(known.end_s, asked.end_s + kMarginS));
  Cut(clean.begin_s - 1.0, clean.end_s + 1.0, in.imu);
  Cut(clean.begin_s, clean.end_s, in.positions);
  Cut(clean.begin_s, clean.end_s, in.velocities);
  Cut(clean.begin_s, clean.end_s, in.attitudes);
  Cut(clean.begin_s, clean.end_s, in.heights);
  Cut(clean.begin_s, clean.end_s, in.ranges);

  if (in.positions.empty() && in.markers.empty()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kNothingToStartFrom);
  }
  return clean;
}

// Attitudes carried to the knots where no inertial samples do it: between two fixes close in time the
// shortest turn is far nearer to the truth than any turn between knots a second apart. Fixes too sparse for
// that stay as they are.
std::vector<AttitudeFix> AttitudesAtKnots(const std::vector<AttitudeFix>& fixes,
                                          const std::vector<double>& knot_times_s) {
  constexpr double kCloseS = 1.2;
  constexpr double kSameTimeS = 1.0e-4;
  constexpr double kAngularAcceleration = 0.5;  // rad/s2, of a usual multirotor manoeuvre
  std::vector<AttitudeFix> at_knots;
  std::size_t knot = 0;
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    const AttitudeFix& a = fixes[k];
    while (knot < knot_times_s.size() && knot_times_s[knot] < a.t_s - kSameTimeS) ++knot;
    const bool on_knot = knot < knot_times_s.size() && knot_times_s[knot] <= a.t_s + kSameTimeS;
    const double before = k > 0 ? a.t_s - fixes[k - 1].t_s : kCloseS;
    const double after = k + 1 < fixes.size() ? fixes[k + 1].t_s - a.t_s : kCloseS;
    if (on_knot || std::min(before, after) >= kCloseS) at_knots.push_back(a);
    if (k + 1 == fixes.size() || after >= kCloseS) continue;
    for (std::size_t i = knot; i < knot_times_s.size() && knot_times_s[i] < fixes[k + 1].t_s - kSameTimeS;
         ++i) {
      if (knot_times_s[i] <= a.t_s + kSameTimeS) continue;
      const double w = (knot_times_s[i] - a.t_s) / after;
      AttitudeFix between = a;
      between.t_s = knot_times_s[i];
      between.enu_from_body = a.enu_from_body.slerp(w, fixes[k + 1].enu_from_body).normalized();
      between.sigma_rad = std::hypot(a.sigma_rad, 0.5 * kAngularAcceleration * after * after * w * (1.0 - w));
      between.has_yaw = a.has_yaw && fixes[k + 1].has_yaw;
      at_knots.push_back(between);
    }
  }
  return at_knots;
}

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
