// The factors of a ChainProblem, visited in one order for its cost and for its normal equations.
#include <cmath>

#include "core/poses/smoother/chain_problem.h"

namespace skyquilt::poses {
namespace {

// Huber: quadratic up to `bound`, then straight.
struct Robust {
  double cost = 0.0;
  double weight = 1.0;
};
Robust Huber(double squared_norm, bool robust, double bound) {
  if (!robust || squared_norm <= bound * bound) return {0.5 * squared_norm, 1.0};
  const double norm = std::sqrt(squared_norm);
  return {bound * norm - 0.5 * bound * bound, bound / norm};
}
// The bound grows with the number of residuals in a factor, whose norm grows with its root.
template <int M>
double Bound(double sigmas) {
  return sigmas + std::sqrt(static_cast<double>(M)) - 1.0;
}

struct CostSink {
  double huber_sigmas;
  SmootherReport* report;
  double cost = 0.0;

  template <int M>
  void Add(const char* kind, int, int, const Linear<M>& linear, bool robust) {
    const Robust r = Huber(linear.residual.squaredNorm(), robust, Bound<M>(huber_sigmas));
    cost += r.cost;
    if (report == nullptr) return;
    ++report->used[kind];
    if (r.weight < 1.0) ++report->down_weighted[kind];
  }
};

struct LinearSink {
  double huber_sigmas;
  BlockSkyline& matrix;
  std::vector<Vector22>& gradient;
  int border;  // -1: none
  const Vector22& border_mask;
  double cost = 0.0;

  template <int M>
  void Add(const char*, int a, int b, const Linear<M>& linear, bool robust) {
    const Robust r = Huber(linear.residual.squaredNorm(), robust, Bound<M>(huber_sigmas));
    cost += r.cost;
    AddRows(a, b, r.weight, linear.residual, linear.by_first, linear.by_second, linear.by_border);
  }

  // For all heights of a factor, which the compiler would otherwise write out one by one.
  using Rows = Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, kStateSize>>;
  void AddRows(int a, int b, double weight, const Eigen::Ref<const Eigen::VectorXd>& residual,
               const Rows& by_first, const Rows& by_second, const Rows& by_border) {
    using Columns = Eigen::Matrix<double, kStateSize, Eigen::Dynamic, 0, kStateSize, kStateSize>;
    const Columns first = weight * by_first.transpose();
    matrix.At(a, a).noalias() += first * by_first;
    gradient[Index(a)].noalias() += first * residual;
    const bool has_border = border >= 0 && a != border && !by_border.isZero(0.0);
    Columns common;
    if (has_border) {
      common = weight * border_mask.asDiagonal() * by_border.transpose();
      matrix.At(border, border).noalias() += common * by_border * border_mask.asDiagonal();
      matrix.At(border, a).noalias() += common * by_first;
      gradient[Index(border)].noalias() += common * residual;
    }
    if (b < 0) return;
    const Columns second = weight * by_second.transpose();
    matrix.At(b, b).noalias() += second * by_second;
    gradient[Index(b)].noalias() += second * residual;
    if (b > a) {
      matrix.At(b, a).noalias() += second * by_first;
    } else {
      matrix.At(a, b).noalias() += first * by_second;
    }
    if (has_border) matrix.At(border, b).noalias() += common * by_second;
  }
};

}  // namespace

template <typename Sink>
void ChainProblem::VisitMotion(const ChainGuess& guess, Sink& sink) const {
  const SmootherOptions& o = input_.options;
  constexpr double kGyroBiasWalk = 2.0e-5;   // rad/s/sqrt(s)
  constexpr double kAccelBiasWalk = 1.0e-3;  // m/s2/sqrt(s)
  constexpr double kGnssBiasTimeS = 120.0, kStillRotationSigmaRad = 1.0e-4;
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const KnotState& a = guess.knots[Index(i)];
    const KnotState& b = guess.knots[Index(i) + 1];
    const double duration_s = timeline_.Duration(i);
    if (HasImu(i)) {
      sink.template Add<9>("imu", i, i + 1,
                           ImuFactor(a, b, Imu(i).delta, imu_whiten_[Index(i)], o.gravity_mps2), false);
    } else {
      sink.template Add<9>("motion prior", i, i + 1,
                           MotionPriorFactor(a, b, duration_s, o.acceleration_density, o.rotation_walk),
                           false);
    }
    BiasWalk walk;
    walk.gyro = kGyroBiasWalk * std::sqrt(duration_s);
    walk.accel = kAccelBiasWalk * std::sqrt(duration_s);
    walk.baro = o.baro_bias_walk * std::sqrt(duration_s);
    walk.gnss_keep = std::exp(-duration_s / kGnssBiasTimeS);
    walk.attitude_keep = std::exp(-duration_s / o.attitude_bias_time_s);
    walk.gnss = o.gnss_bias_sigma_m * std::sqrt(1.0 - walk.gnss_keep * walk.gnss_keep);
    walk.attitude = o.attitude_bias_sigma_rad * std::sqrt(1.0 - walk.attitude_keep * walk.attitude_keep);
    // A tilt error stays with the airframe (a biased accelerometer) or with the ground (a late velocity):
    // what the second kind does in a turn must be free, or turns would seem to show the true vertical.
    const double swing = std::sqrt(2.0 - 2.0 * std::cos(turned_rad_[Index(i)]));
    for (int axis = 0; axis < 2; ++axis) {
      walk.attitude(axis) = std::hypot(walk.attitude(axis), swing * o.attitude_bias_sigma_rad(axis));
    }
    sink.template Add<13>("bias walk", i, i + 1, BiasWalkFactor(a, b, walk), false);
    if (still_[Index(i)] && still_[Index(i) + 1]) {
      sink.template Add<3>("still rotation", i, i + 1, StillRotationFactor(a, b, kStillRotationSigmaRad),
                           true);
    }
  }
}

template <typename Sink>
void ChainProblem::VisitPriors(const ChainGuess& guess, Sink& sink) const {
  const SmootherOptions& o = input_.options;
  constexpr double kPositionSigmaM = 1.0e4, kVelocitySigmaMps = 30.0, kTiltSigmaRad = 0.5, kYawSigmaRad = 2.0;
  constexpr double kGyroBiasSigmaRadps = 0.0087;  // 0.5 deg/s
  constexpr double kAccelBiasSigmaMps2 = 0.05;    // 5 mg
  const KnotState& k = guess.knots.front();
  const StateBetween s = StateAtKnot(k);
  Linear<22> prior;
  const auto hold = [&](int at, double value, double sigma) {
    prior.residual(at) = value / sigma;
    prior.by_first(at, at) = 1.0 / sigma;
  };
  for (int i = 0; i < 3; ++i) {
    hold(kAtVelocity + i, k.velocity_in_enu_mps(i), kVelocitySigmaMps);
    hold(kAtPosition + i, k.position_in_enu_m(i), kPositionSigmaM);
    hold(kAtGyroBias + i, k.gyro_bias_radps(i), kGyroBiasSigmaRadps);
    hold(kAtAccelBias + i, k.accel_bias_mps2(i), kAccelBiasSigmaMps2);
    hold(kAtGnssBias + i, k.gnss_bias_in_enu_m(i), o.gnss_bias_sigma_m(i));
    hold(kAtAttitudeBias + i, k.attitude_bias_rad(i), o.attitude_bias_sigma_rad(i));
  }
  hold(kAtBaroBias, k.baro_bias_m, o.baro_bias_first_sigma_m);
  sink.template Add<22>("prior", 0, -1, prior, false);
  StateBetween unbiased = s;
  unbiased.state.attitude_bias_rad.setZero();
  Linear<3> rotation = AttitudeFactor(unbiased, *first_rotation_, kTiltSigmaRad, kYawSigmaRad);
  rotation.by_first.middleCols<3>(kAtAttitudeBias).setZero();
  sink.template Add<3>("prior", 0, -1, rotation, false);
  if (!has_border_) return;
  Linear<22> border;
  for (int i = 0; i < kStateSize; ++i) {
    const double sigma = border_sigma_(i) > 0.0 ? border_sigma_(i) : 1.0;
    border.residual(i) = guess.border.value(i) / sigma;
    border.by_first(i, i) = 1.0 / sigma;
  }
  sink.template Add<22>("prior", timeline_.size(), -1, border, false);
}

template <typename Sink>
void ChainProblem::VisitFixes(const ChainGuess& guess, Sink& sink) const {
  const SmootherOptions& o = input_.options;
  const auto add = [&]<int M>(const char* kind, const Placed& p, const Linear<M>& linear, bool robust) {
    sink.template Add<M>(kind, p.place.knot, p.place.weight > 0.0 ? p.place.knot + 1 : -1, linear, robust);
  };
  for (const Placed& p : positions_) {
    const PositionFix& f = input_.positions[Index(p.fix)];
    add("gnss position", p, PositionFactor(At(guess.knots, p), guess.border, f.position_in_enu_m, f.sigma_m),
        true);
  }
  for (const Placed& p : velocities_) {
    const VelocityFix& f = input_.velocities[Index(p.fix)];
    add("gnss velocity", p,
        VelocityFactor(At(guess.knots, p), guess.border, f.velocity_in_enu_mps, f.sigma_mps), true);
  }
  for (const Placed& p : attitudes_) {
    const AttitudeFix& f = input_.attitudes[Index(p.fix)];
    add("attitude", p,
        AttitudeFactor(At(guess.knots, p), f.enu_from_body, f.sigma_rad, f.has_yaw ? f.sigma_rad : 100.0),
        true);
  }
  for (const Placed& p : heights_) {
    const HeightFix& f = input_.heights[Index(p.fix)];
    add("height", p, HeightFactor(At(guess.knots, p), f.z_in_enu_m, f.sigma_m), true);
  }
  for (const Placed& p : ranges_) {
    const RangeFix& f = input_.ranges[Index(p.fix)];
    const double sigma = 0.1 + 0.02 * f.distance_m;
    add("range", p, RangeFactor(At(guess.knots, p), f.distance_m, input_.ground_z_in_enu_m, sigma), true);
  }
  for (const Placed& p : markers_) {
    const Marker& f = input_.markers[Index(p.fix)];
    const StateBetween s = At(guess.knots, p);
    add("marker", p, MarkerFactor(s, f.position_in_enu_m, f.sigma_m), false);
    if (f.yaw_rad) add("marker", p, YawFactor(s, *f.yaw_rad, f.sigma_yaw_rad), false);
  }
  constexpr double kAssumptionSigmaRad = 0.02;  // the slow part is the attitude bias
  constexpr double kStillVelocitySigmaMps = 0.02;
  for (int k = 0; k < timeline_.size(); ++k) {
    const KnotState& knot = guess.knots[Index(k)];
    if (still_[Index(k)]) {
      sink.template Add<3>("still", k, -1, StillVelocityFactor(knot, kStillVelocitySigmaMps), true);
    }
    if (o.assume_level)
      sink.template Add<2>("level", k, -1, LevelFactor(StateAtKnot(knot), kAssumptionSigmaRad), true);
    if (o.yaw_from_course && has_course_[Index(k)]) {
      sink.template Add<1>("course", k, -1, CourseFactor(StateAtKnot(knot), kAssumptionSigmaRad), true);
    }
    if (course_evidence_ && course_evidence_->runs_straight[Index(k)]) {
      // A nose errs about its course for as long as a compass does: white noise of the same density.
      const double step_s = 0.5 * (timeline_.times()[Index(k) + 1] - timeline_.times()[Index(k) - 1]);
      const double sigma = course_evidence_->sigma_rad * std::sqrt(2.0 * o.attitude_bias_time_s / step_s);
      StateBetween nose = StateAtKnot(knot);
      nose.state.attitude_bias_rad.setZero();
      Linear<1> course = CourseFactor(nose, sigma);
      course.by_first.middleCols<3>(kAtAttitudeBias).setZero();
      sink.template Add<1>("course", k, -1, course, true);
    }
  }
}

template <typename Sink>
void ChainProblem::Visit(const ChainGuess& guess, Sink& sink) const {
  VisitPriors(guess, sink);
  VisitMotion(guess, sink);
  VisitFixes(guess, sink);
}

double ChainProblem::Cost(const ChainGuess& guess, SmootherReport* report) const {
  CostSink sink{input_.options.huber_sigmas, report};
  Visit(guess, sink);
  return sink.cost;
}

double ChainProblem::Linearise(const ChainGuess& guess, BlockSkyline& matrix,
                               std::vector<Vector22>& gradient) const {
  matrix.SetZero();
  gradient.assign(Index(matrix.size()), Vector22::Zero());
  Vector22 mask;
  for (int i = 0; i < kStateSize; ++i) mask(i) = border_sigma_(i) > 0.0 ? 1.0 : 0.0;
  LinearSink sink{input_.options.huber_sigmas, matrix, gradient, has_border_ ? timeline_.size() : -1, mask};
  Visit(guess, sink);
  return sink.cost;
}

}  // namespace skyquilt::poses
