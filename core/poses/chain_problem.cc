#include "core/poses/chain_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"

namespace skyquilt::poses {
namespace {

std::size_t At0(int i) { return static_cast<std::size_t>(i); }

// Floors on the inertial sums: sampling and timing are never better, and they keep the system well
// conditioned.
void AddFloor(double duration_s, Matrix9d& covariance) {
  const double rotation = 2.0e-6, velocity = 2.0e-5, position = 2.0e-4;
  covariance.diagonal().head<3>().array() += rotation * rotation * duration_s;
  covariance.diagonal().segment<3>(3).array() += velocity * velocity * duration_s;
  covariance.diagonal().tail<3>().array() += position * position * duration_s;
}

}  // namespace

ChainProblem::ChainProblem(const SmootherInput& input, ChainTimeline timeline)
    : input_(input),
      timeline_(std::move(timeline)),
      imu_(At0(timeline_.size() - 1)),
      imu_whiten_(At0(timeline_.size() - 1), Matrix9d::Identity()),
      cuts_(At0(timeline_.size())),
      still_(At0(timeline_.size()), false),
      has_course_(At0(timeline_.size()), false),
      turned_rad_(At0(timeline_.size() - 1), 0.0) {
  for (const double t : input_.photo_times_s) photo_knots_.push_back(timeline_.Nearest(t));
  positions_ = PlaceAll(input_.positions);
  velocities_ = PlaceAll(input_.velocities);
  attitudes_ = PlaceAll(input_.attitudes);
  heights_ = PlaceAll(input_.heights);
  ranges_ = PlaceAll(input_.ranges);
  markers_ = PlaceAll(input_.markers);
  for (std::vector<double>& cuts : cuts_) {
    std::sort(cuts.begin(), cuts.end());
    cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
  }
  const auto find_cuts = [&](std::vector<Placed>& series, auto time_of) {
    for (Placed& placed : series) {
      if (placed.place.weight == 0.0) continue;
      const std::vector<double>& cuts = cuts_[At0(placed.place.knot)];
      placed.cut =
          static_cast<int>(std::lower_bound(cuts.begin(), cuts.end(), time_of(placed.fix)) - cuts.begin());
    }
  };
  find_cuts(positions_, [&](int k) { return input_.positions[At0(k)].t_s; });
  find_cuts(velocities_, [&](int k) { return input_.velocities[At0(k)].t_s; });
  find_cuts(attitudes_, [&](int k) { return input_.attitudes[At0(k)].t_s; });
  find_cuts(heights_, [&](int k) { return input_.heights[At0(k)].t_s; });
  find_cuts(ranges_, [&](int k) { return input_.ranges[At0(k)].t_s; });
  find_cuts(markers_, [&](int k) { return input_.markers[At0(k)].t_s; });
  for (int k = 0; k < timeline_.size(); ++k) {
    const double t = timeline_.times()[At0(k)];
    for (const StillInterval& s : input_.still)
      still_[At0(k)] = still_[At0(k)] || (t >= s.begin_s && t <= s.end_s);
  }
  const SmootherOptions& o = input_.options;
  border_prior_.segment<3>(kAtLeverGnss) = o.lever_gnss_in_body_m;
  border_prior_.segment<3>(kAtLeverCamera) = o.lever_camera_in_body_m;
  border_sigma_(kAtTauGnss) = o.tau_gnss_sigma_s;
  border_sigma_.segment<3>(kAtLeverGnss).setConstant(o.lever_gnss_sigma_m);
  border_sigma_(kAtTauCamera) = o.tau_camera_sigma_s;
  border_sigma_.segment<3>(kAtBoresight).setConstant(o.boresight_sigma_rad);
  border_sigma_.segment<3>(kAtLeverCamera).setConstant(o.lever_camera_sigma_m);
  has_border_ = border_sigma_.maxCoeff() > 0.0;
}

template <typename Fix>
std::vector<ChainProblem::Placed> ChainProblem::PlaceAll(const std::vector<Fix>& fixes) {
  std::vector<Placed> placed;
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    const std::optional<TimePlace> place = timeline_.Place(fixes[k].t_s);
    if (!place) continue;
    placed.push_back({*place, -1, static_cast<int>(k)});
    if (place->weight > 0.0) cuts_[At0(place->knot)].push_back(fixes[k].t_s);
  }
  return placed;
}

int ChainProblem::ImuIntervals() const {
  return static_cast<int>(
      std::count_if(imu_.begin(), imu_.end(), [](const auto& p) { return p.has_value(); }));
}

void ChainProblem::ExpandAbout(const std::vector<KnotState>& knots) {
  SKYQUILT_CHECK(static_cast<int>(knots.size()) == timeline_.size(), "a guess has one state a knot");
  if (!first_rotation_) first_rotation_ = knots.front().enu_from_body;
  for (int k = 0; k < timeline_.size(); ++k) {
    has_course_[At0(k)] =
        knots[At0(k)].velocity_in_enu_mps.head<2>().norm() > input_.options.course_min_speed_mps;
  }
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const Eigen::Vector3d before = knots[At0(i)].enu_from_body * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d after = knots[At0(i) + 1].enu_from_body * Eigen::Vector3d::UnitX();
    turned_rad_[At0(i)] =
        std::atan2(before.x() * after.y() - before.y() * after.x(), before.head<2>().dot(after.head<2>()));
  }
  const bool has_headings = std::any_of(input_.attitudes.begin(), input_.attitudes.end(),
                                        [](const AttitudeFix& a) { return a.has_yaw; });
  if (has_headings && input_.imu.empty())
    course_evidence_ = JudgeCourse(knots, timeline_.times(), input_.options.course_min_speed_mps);
  if (input_.imu.empty()) return;
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const KnotState& k = knots[At0(i)];
    imu_[At0(i)] =
        poses::Preintegrate(input_.imu, timeline_.times()[At0(i)], timeline_.times()[At0(i) + 1],
                            cuts_[At0(i)], k.gyro_bias_radps, k.accel_bias_mps2, input_.options.imu);
    if (!imu_[At0(i)]) continue;
    Matrix9d covariance = imu_[At0(i)]->covariance;
    AddFloor(timeline_.Duration(i), covariance);
    imu_whiten_[At0(i)] = Eigen::LLT<Matrix9d>(covariance).matrixL().solve(Matrix9d::Identity());
  }
}

std::vector<int> ChainProblem::Outline(bool with_photo_neighbours) const {
  std::vector<int> first(At0(timeline_.size()));
  for (int k = 0; k < timeline_.size(); ++k) first[At0(k)] = std::max(0, k - 1);
  const auto reach = [&](int a, int b) {
    first[At0(std::max(a, b))] = std::min(first[At0(std::max(a, b))], std::min(a, b));
  };
  for (const PhotoPair& pair : input_.pairs) reach(PhotoKnot(pair.first), PhotoKnot(pair.second));
  if (with_photo_neighbours) {
    for (std::size_t k = 1; k < photo_knots_.size(); ++k) reach(photo_knots_[k - 1], photo_knots_[k]);
  }
  if (has_border_) first.push_back(0);
  return first;
}

StateBetween ChainProblem::At(const std::vector<KnotState>& knots, const Placed& placed) const {
  const int k = placed.place.knot;
  if (placed.place.weight == 0.0) {
    StateBetween s = StateAtKnot(knots[At0(k)]);
    const int interval = std::min(k, timeline_.size() - 2);
    if (interval >= 0 && HasImu(interval)) {
      // What the lever arm and the clock offset need: the rate and the acceleration at the knot.
      const ImuDelta& d = k > 0 && HasImu(k - 1) ? Imu(k - 1).delta : Imu(interval).delta;
      s.rate_radps = d.end_rate_radps - s.state.gyro_bias_radps;
      s.acceleration_mps2 = s.state.enu_from_body * (d.end_force_mps2 - s.state.accel_bias_mps2);
      s.acceleration_mps2.z() -= input_.options.gravity_mps2;
    }
    return s;
  }
  const KnotState& a = knots[At0(k)];
  const KnotState& b = knots[At0(k) + 1];
  if (HasImu(k)) {
    return StateByImu(a, b, placed.place.weight, Imu(k).at_cuts[At0(placed.cut)],
                      input_.options.gravity_mps2);
  }
  return StateByMotionPrior(a, b, placed.place.weight, timeline_.Duration(k),
                            input_.options.acceleration_density, input_.options.rotation_walk);
}

template <typename Sink>
void ChainProblem::VisitMotion(const ChainGuess& guess, Sink& sink) const {
  const SmootherOptions& o = input_.options;
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const KnotState& a = guess.knots[At0(i)];
    const KnotState& b = guess.knots[At0(i) + 1];
    const double T = timeline_.Duration(i);
    if (HasImu(i)) {
      sink.template Add<9>("imu", i, i + 1,
                           ImuFactor(a, b, Imu(i).delta, imu_whiten_[At0(i)], o.gravity_mps2), false);
    } else {
      sink.template Add<9>("motion prior", i, i + 1,
                           MotionPriorFactor(a, b, T, o.acceleration_density, o.rotation_walk), false);
    }
    BiasWalk walk;
    walk.gyro = o.imu.gyro_bias_walk * std::sqrt(T);
    walk.accel = o.imu.accel_bias_walk * std::sqrt(T);
    walk.baro = o.baro_bias_walk * std::sqrt(T);
    walk.gnss_keep = std::exp(-T / o.gnss_bias_time_s);
    walk.attitude_keep = std::exp(-T / o.attitude_bias_time_s);
    walk.gnss = o.gnss_bias_sigma_m * std::sqrt(1.0 - walk.gnss_keep * walk.gnss_keep);
    walk.attitude = o.attitude_bias_sigma_rad * std::sqrt(1.0 - walk.attitude_keep * walk.attitude_keep);
    // A tilt error stays with the airframe (a biased accelerometer) or with the ground (a late velocity):
    // what the second kind does in a turn must be free, or turns would seem to show the true vertical.
    const double swing = std::sqrt(2.0 - 2.0 * std::cos(turned_rad_[At0(i)]));
    for (int axis = 0; axis < 2; ++axis) {
      walk.attitude(axis) = std::hypot(walk.attitude(axis), swing * o.attitude_bias_sigma_rad(axis));
    }
    sink.template Add<13>("bias walk", i, i + 1, BiasWalkFactor(a, b, walk), false);
    if (still_[At0(i)] && still_[At0(i) + 1]) {
      sink.template Add<3>("still rotation", i, i + 1, StillRotationFactor(a, b, o.still_rotation_sigma_rad),
                           true);
    }
  }
}

template <typename Sink>
void ChainProblem::VisitPriors(const ChainGuess& guess, Sink& sink) const {
  const SmootherOptions& o = input_.options;
  const KnotState& k = guess.knots.front();
  const StateBetween s = StateAtKnot(k);
  Linear<22> prior;
  const auto hold = [&](int at, double value, double sigma) {
    prior.residual(at) = value / sigma;
    prior.by_first(at, at) = 1.0 / sigma;
  };
  for (int i = 0; i < 3; ++i) {
    hold(kAtVelocity + i, k.velocity_in_enu_mps(i), o.first_velocity_sigma_mps);
    hold(kAtPosition + i, k.position_in_enu_m(i), o.first_position_sigma_m);
    hold(kAtGyroBias + i, k.gyro_bias_radps(i), o.imu.gyro_bias_sigma);
    hold(kAtAccelBias + i, k.accel_bias_mps2(i), o.imu.accel_bias_sigma);
    hold(kAtGnssBias + i, k.gnss_bias_in_enu_m(i), o.gnss_bias_sigma_m(i));
    hold(kAtAttitudeBias + i, k.attitude_bias_rad(i), o.attitude_bias_sigma_rad(i));
  }
  hold(kAtBaroBias, k.baro_bias_m, o.baro_bias_first_sigma_m);
  sink.template Add<22>("prior", 0, -1, prior, false);
  StateBetween unbiased = s;
  unbiased.state.attitude_bias_rad.setZero();
  Linear<3> rotation =
      AttitudeFactor(unbiased, *first_rotation_, o.first_tilt_sigma_rad, o.first_yaw_sigma_rad);
  rotation.by_first.middleCols<3>(kAtAttitudeBias).setZero();
  sink.template Add<3>("prior", 0, -1, rotation, false);
  if (!has_border_) return;
  Linear<22> border;
  for (int i = 0; i < kStateSize; ++i) {
    const double sigma = border_sigma_(i) > 0.0 ? border_sigma_(i) : 1.0;
    border.residual(i) = (guess.border.value(i) - border_prior_(i)) / sigma;
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
    const PositionFix& f = input_.positions[At0(p.fix)];
    add("gnss position", p, PositionFactor(At(guess.knots, p), guess.border, f.position_in_enu_m, f.sigma_m),
        true);
  }
  for (const Placed& p : velocities_) {
    const VelocityFix& f = input_.velocities[At0(p.fix)];
    add("gnss velocity", p,
        VelocityFactor(At(guess.knots, p), guess.border, f.velocity_in_enu_mps, f.sigma_mps), true);
  }
  for (const Placed& p : attitudes_) {
    const AttitudeFix& f = input_.attitudes[At0(p.fix)];
    add("attitude", p,
        AttitudeFactor(At(guess.knots, p), f.enu_from_body, f.sigma_rad, f.has_yaw ? f.sigma_rad : 100.0),
        true);
  }
  for (const Placed& p : heights_) {
    const HeightFix& f = input_.heights[At0(p.fix)];
    add("height", p, HeightFactor(At(guess.knots, p), f.z_in_enu_m, f.sigma_m), true);
  }
  for (const Placed& p : ranges_) {
    const RangeFix& f = input_.ranges[At0(p.fix)];
    const double sigma = 0.1 + 0.02 * f.distance_m;
    add("range", p, RangeFactor(At(guess.knots, p), f.distance_m, input_.ground_z_in_enu_m, sigma), true);
  }
  for (const Placed& p : markers_) {
    const Marker& f = input_.markers[At0(p.fix)];
    const StateBetween s = At(guess.knots, p);
    add("marker", p, MarkerFactor(s, f.position_in_enu_m, f.sigma_m), false);
    if (f.yaw_rad) add("marker", p, YawFactor(s, *f.yaw_rad, f.sigma_yaw_rad), false);
  }
  for (const PhotoPair& f : input_.pairs) {
    const int a = PhotoKnot(f.first);
    const int b = PhotoKnot(f.second);
    sink.template Add<6>("photo pair", a, b,
                         PairFactor(guess.knots[At0(a)], guess.knots[At0(b)], guess.border, f.rotation,
                                    f.translation_per_height, input_.ground_z_in_enu_m, f.sigma_rotation_rad,
                                    f.sigma_translation_per_height),
                         true);
  }
  constexpr double kAssumptionSigmaRad = 0.02;  // the slow part is the attitude bias
  for (int k = 0; k < timeline_.size(); ++k) {
    const KnotState& knot = guess.knots[At0(k)];
    if (still_[At0(k)]) {
      sink.template Add<3>("still", k, -1, StillVelocityFactor(knot, o.still_velocity_sigma_mps), true);
    }
    if (o.assume_level)
      sink.template Add<2>("level", k, -1, LevelFactor(StateAtKnot(knot), kAssumptionSigmaRad), true);
    if (o.yaw_from_course && has_course_[At0(k)]) {
      sink.template Add<1>("course", k, -1, CourseFactor(StateAtKnot(knot), kAssumptionSigmaRad), true);
    }
    if (course_evidence_ && course_evidence_->runs_straight[At0(k)]) {
      // A nose errs about its course for as long as a compass does: white noise of the same density stands
      // for it.
      const double step_s = 0.5 * (timeline_.times()[At0(k) + 1] - timeline_.times()[At0(k) - 1]);
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
  FactorCount* count;
  double cost = 0.0;

  template <int M>
  void Add(const char* kind, int, int, const Linear<M>& linear, bool robust) {
    const Robust r = Huber(linear.residual.squaredNorm(), robust, Bound<M>(huber_sigmas));
    cost += r.cost;
    if (!count) return;
    ++count->used[kind];
    if (r.weight < 1.0) ++count->down_weighted[kind];
    if (robust) count->residuals += M;
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
    const Eigen::Matrix<double, kStateSize, M> first = r.weight * linear.by_first.transpose();
    matrix.At(a, a).noalias() += first * linear.by_first;
    gradient[At0(a)].noalias() += first * linear.residual;
    const bool has_border = border >= 0 && a != border && !linear.by_border.isZero(0.0);
    Eigen::Matrix<double, kStateSize, M> common;
    if (has_border) {
      common = r.weight * border_mask.asDiagonal() * linear.by_border.transpose();
      matrix.At(border, border).noalias() += common * linear.by_border * border_mask.asDiagonal();
      matrix.At(border, a).noalias() += common * linear.by_first;
      gradient[At0(border)].noalias() += common * linear.residual;
    }
    if (b < 0) return;
    const Eigen::Matrix<double, kStateSize, M> second = r.weight * linear.by_second.transpose();
    matrix.At(b, b).noalias() += second * linear.by_second;
    gradient[At0(b)].noalias() += second * linear.residual;
    if (b > a) {
      matrix.At(b, a).noalias() += second * linear.by_first;
    } else {
      matrix.At(a, b).noalias() += first * linear.by_second;
    }
    if (has_border) matrix.At(border, b).noalias() += common * linear.by_second;
  }
};

}  // namespace

double ChainProblem::Cost(const ChainGuess& guess, FactorCount* count) const {
  CostSink sink{input_.options.huber_sigmas, count};
  Visit(guess, sink);
  return sink.cost;
}

double ChainProblem::Linearise(const ChainGuess& guess, BlockSkyline& matrix,
                               std::vector<Vector22>& gradient) const {
  matrix.SetZero();
  gradient.assign(At0(matrix.size()), Vector22::Zero());
  Vector22 mask;
  for (int i = 0; i < kStateSize; ++i) mask(i) = border_sigma_(i) > 0.0 ? 1.0 : 0.0;
  LinearSink sink{input_.options.huber_sigmas, matrix, gradient, has_border_ ? timeline_.size() : -1, mask};
  Visit(guess, sink);
  return sink.cost;
}

}  // namespace skyquilt::poses
