#include "core/poses/smoother/chain_problem.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "core/base/check.h"
#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::poses {
namespace {

constexpr double kSameTimeS = 1.0e-4;
constexpr double kStraightRadps = 0.087;  // 5 deg/s
constexpr double kBestSigmaRad = 0.035;   // no nose is known to keep to its course better: 2 deg
constexpr double kWorstSigmaRad = 0.26;   // beyond 15 deg it does not keep to it
constexpr std::size_t kFewestApart = 10;

// Floors on the inertial sums: sampling and timing are never better, and they keep the system well
// conditioned.
void AddFloor(double duration_s, Matrix9d& covariance) {
  const double rotation = 2.0e-6, velocity = 2.0e-5, position = 2.0e-4;
  covariance.diagonal().head<3>().array() += rotation * rotation * duration_s;
  covariance.diagonal().segment<3>(3).array() += velocity * velocity * duration_s;
  covariance.diagonal().tail<3>().array() += position * position * duration_s;
}

}  // namespace

ChainTimeline::ChainTimeline(double begin_s, double end_s, const std::vector<double>& fixed_times,
                             double spacing_s) {
  SKYQUILT_CHECK(spacing_s > 0.0 && end_s >= begin_s, "a chain needs a positive spacing and a rising span");
  times_.push_back(begin_s);
  const auto reach = [&](double t) {
    const double gap = t - times_.back();
    if (gap <= kSameTimeS) return;
    const int parts = std::max(1, static_cast<int>(std::ceil(gap / spacing_s - 1e-9)));
    const double from = times_.back();
    for (int k = 1; k < parts; ++k) times_.push_back(from + gap * k / parts);
    times_.push_back(t);
  };
  for (const double t : fixed_times) reach(t);
  reach(end_s);
}

double ChainTimeline::Duration(int interval) const {
  return times_[Index(interval) + 1] - times_[Index(interval)];
}

std::optional<TimePlace> ChainTimeline::Place(double t_s) const {
  if (t_s < times_.front() - kSameTimeS || t_s > times_.back() + kSameTimeS) return std::nullopt;
  const int nearest = Nearest(t_s);
  if (std::abs(times_[Index(nearest)] - t_s) <= kSameTimeS) return TimePlace{nearest, 0.0};
  const auto next = std::upper_bound(times_.begin(), times_.end(), t_s);
  const int knot = static_cast<int>(next - times_.begin()) - 1;
  return TimePlace{knot, (t_s - times_[Index(knot)]) / Duration(knot)};
}

int ChainTimeline::Nearest(double t_s) const {
  const auto next = std::lower_bound(times_.begin(), times_.end(), t_s);
  if (next == times_.begin()) return 0;
  if (next == times_.end()) return size() - 1;
  const auto index = static_cast<int>(next - times_.begin());
  return *next - t_s < t_s - *(next - 1) ? index : index - 1;
}

std::optional<CourseEvidence> JudgeCourse(const std::vector<KnotState>& knots,
                                          const std::vector<double>& times_s) {
  std::vector<double> nose, course;
  for (const KnotState& knot : knots) {
    nose.push_back(HeadingOf(knot.enu_from_body * Eigen::Vector3d::UnitX()));
    course.push_back(HeadingOf(knot.velocity_in_enu_mps));
  }
  CourseEvidence evidence;
  evidence.runs_straight.assign(knots.size(), false);
  std::vector<double> apart;
  for (std::size_t k = 1; k + 1 < knots.size(); ++k) {
    const double most = kStraightRadps * (times_s[k + 1] - times_s[k - 1]);
    evidence.runs_straight[k] = knots[k].velocity_in_enu_mps.head<2>().norm() > kCourseMinSpeedMps &&
                                std::abs(geo::WrapRad(nose[k + 1] - nose[k - 1])) < most &&
                                std::abs(geo::WrapRad(course[k + 1] - course[k - 1])) < most;
    if (evidence.runs_straight[k]) apart.push_back(std::abs(geo::WrapRad(nose[k] - course[k])));
  }
  if (apart.size() < kFewestApart) return std::nullopt;
  evidence.sigma_rad = std::max(kBestSigmaRad, kSigmaOfMedian * Median(std::move(apart)));
  if (evidence.sigma_rad > kWorstSigmaRad) return std::nullopt;
  return evidence;
}

ChainProblem::ChainProblem(const SmootherInput& input, ChainTimeline timeline)
    : input_(input),
      timeline_(std::move(timeline)),
      imu_(Index(timeline_.size() - 1)),
      imu_whiten_(Index(timeline_.size() - 1), Matrix9d::Identity()),
      cuts_(Index(timeline_.size())),
      still_(Index(timeline_.size()), false),
      has_course_(Index(timeline_.size()), false),
      turned_rad_(Index(timeline_.size() - 1), 0.0) {
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
  for (auto* series : {&positions_, &velocities_, &attitudes_, &heights_, &ranges_, &markers_}) {
    for (Placed& placed : *series) {
      if (placed.place.weight == 0.0) continue;
      const std::vector<double>& cuts = cuts_[Index(placed.place.knot)];
      placed.cut = static_cast<int>(std::lower_bound(cuts.begin(), cuts.end(), placed.t_s) - cuts.begin());
    }
  }
  for (int k = 0; k < timeline_.size(); ++k) {
    const double t = timeline_.times()[Index(k)];
    for (const StillInterval& s : input_.still)
      still_[Index(k)] = still_[Index(k)] || (t >= s.begin_s && t <= s.end_s);
  }
  const SmootherOptions& o = input_.options;
  border_sigma_(kAtTauGnss) = o.tau_gnss_sigma_s;
  border_sigma_.segment<3>(kAtLeverGnss).setConstant(o.lever_gnss_sigma_m);
  border_sigma_(kAtTauCamera) = o.tau_camera_sigma_s;
  border_sigma_.segment<3>(kAtBoresight).setConstant(o.boresight_sigma_rad);
  has_border_ = border_sigma_.maxCoeff() > 0.0;
}

template <typename Fix>
std::vector<ChainProblem::Placed> ChainProblem::PlaceAll(const std::vector<Fix>& fixes) {
  std::vector<Placed> placed;
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    const std::optional<TimePlace> place = timeline_.Place(fixes[k].t_s);
    if (!place) continue;
    placed.push_back({*place, -1, static_cast<int>(k), fixes[k].t_s});
    if (place->weight > 0.0) cuts_[Index(place->knot)].push_back(fixes[k].t_s);
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
    has_course_[Index(k)] = knots[Index(k)].velocity_in_enu_mps.head<2>().norm() > kCourseMinSpeedMps;
  }
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const Eigen::Vector3d before = knots[Index(i)].enu_from_body * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d after = knots[Index(i) + 1].enu_from_body * Eigen::Vector3d::UnitX();
    turned_rad_[Index(i)] =
        std::atan2(before.x() * after.y() - before.y() * after.x(), before.head<2>().dot(after.head<2>()));
  }
  const bool has_headings = std::any_of(input_.attitudes.begin(), input_.attitudes.end(),
                                        [](const AttitudeFix& a) { return a.has_yaw; });
  if (has_headings && input_.imu.empty()) course_evidence_ = JudgeCourse(knots, timeline_.times());
  if (input_.imu.empty()) return;
  for (int i = 0; i + 1 < timeline_.size(); ++i) {
    const KnotState& k = knots[Index(i)];
    imu_[Index(i)] =
        poses::Preintegrate(input_.imu, timeline_.times()[Index(i)], timeline_.times()[Index(i) + 1],
                            cuts_[Index(i)], k.gyro_bias_radps, k.accel_bias_mps2, input_.options.imu);
    if (!imu_[Index(i)]) continue;
    Matrix9d covariance = imu_[Index(i)]->covariance;
    AddFloor(timeline_.Duration(i), covariance);
    imu_whiten_[Index(i)] = Eigen::LLT<Matrix9d>(covariance).matrixL().solve(Matrix9d::Identity());
  }
}

std::vector<int> ChainProblem::Outline(bool with_photo_neighbours) const {
  std::vector<int> first(Index(timeline_.size()));
  for (int k = 0; k < timeline_.size(); ++k) first[Index(k)] = std::max(0, k - 1);
  const auto reach = [&](int a, int b) {
    first[Index(std::max(a, b))] = std::min(first[Index(std::max(a, b))], std::min(a, b));
  };
  if (with_photo_neighbours) {
    for (std::size_t k = 1; k < photo_knots_.size(); ++k) reach(photo_knots_[k - 1], photo_knots_[k]);
  }
  if (has_border_) first.push_back(0);
  return first;
}

StateBetween ChainProblem::At(const std::vector<KnotState>& knots, const Placed& placed) const {
  const int k = placed.place.knot;
  if (placed.place.weight == 0.0) {
    StateBetween s = StateAtKnot(knots[Index(k)]);
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
  const KnotState& a = knots[Index(k)];
  const KnotState& b = knots[Index(k) + 1];
  if (HasImu(k)) {
    return StateByImu(a, b, placed.place.weight, Imu(k).at_cuts[Index(placed.cut)],
                      input_.options.gravity_mps2);
  }
  return StateByMotionPrior(a, b, placed.place.weight, timeline_.Duration(k),
                            input_.options.acceleration_density, input_.options.rotation_walk);
}

}  // namespace skyquilt::poses
