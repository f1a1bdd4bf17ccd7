// GuessChain: the smoother's first guess.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/geo/lat_lon.h"
#include "core/geo/rigid3.h"
#include "core/poses/log_span.h"
#include "core/poses/smoother/chain_problem.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// A level body whose nose points at a heading clockwise from north.
Quaterniond LevelBody(double heading) {
  Eigen::Matrix3d r;  // columns: nose, right wing, down
  r.col(0) << std::sin(heading), std::cos(heading), 0.0;
  r.col(1) << std::cos(heading), -std::sin(heading), 0.0;
  r.col(2) << 0.0, 0.0, -1.0;
  return Quaterniond(r);
}
Quaterniond Turned(const Quaterniond& enu_from_body, double clockwise) {
  return (Quaterniond(Eigen::AngleAxisd(-clockwise, Vector3d::UnitZ())) * enu_from_body).normalized();
}
double HeadingOfBody(const Quaterniond& enu_from_body) {
  return HeadingOf(enu_from_body * Vector3d::UnitX());
}

class Guesser {
 public:
  explicit Guesser(ChainProblem& problem)
      : problem_(problem), input_(problem.input()), times_(problem.timeline().times()) {
    guess_.knots.resize(times_.size());
  }

  ChainGuess Make() {
    FromStillness();
    const bool has_track = !input_.positions.empty();
    if (has_track) Track();
    Rotations(has_track);
    problem_.ExpandAbout(guess_.knots);
    if (!has_track) DeadReckon(0);
    problem_.ExpandAbout(guess_.knots);
    return std::move(guess_);
  }

 private:
  // At rest the gyro shows its bias and the accelerometer which way is up.
  void FromStillness() {
    Vector3d rate = Vector3d::Zero();
    Vector3d force = Vector3d::Zero();
    int count = 0;
    for (const flight::ImuSample& s : input_.imu) {
      const auto inside = [&](const StillInterval& i) { return s.t_s >= i.begin_s && s.t_s <= i.end_s; };
      if (input_.still.empty() || !inside(input_.still.front())) continue;
      rate += s.angular_rate_radps;
      force += s.specific_force_mps2;
      ++count;
    }
    if (count < 20) return;
    rate /= count;
    const Quaterniond level = geo::RotationToZ(force);
    double heading = 0.0;
    for (const Marker& m : input_.markers) {
      if (m.yaw_rad) {
        heading = *m.yaw_rad;
        break;
      }
    }
    still_rotation_ = Turned(level, heading - HeadingOfBody(level));
    for (KnotState& k : guess_.knots) k.gyro_bias_radps = rate;
  }

  void Track() {
    for (std::size_t k = 0; k < times_.size(); ++k) {
      const Around<PositionFix> p = AroundTime(input_.positions, times_[k]);
      guess_.knots[k].position_in_enu_m =
          (1.0 - p.weight) * p.before->position_in_enu_m + p.weight * p.after->position_in_enu_m;
    }
    if (input_.velocities.empty()) {
      SpeedsFromPositions(0, static_cast<int>(times_.size()) - 1);
    } else {
      for (std::size_t k = 0; k < times_.size(); ++k) {
        const Around<VelocityFix> v = AroundTime(input_.velocities, times_[k]);
        guess_.knots[k].velocity_in_enu_mps =
            (1.0 - v.weight) * v.before->velocity_in_enu_mps + v.weight * v.after->velocity_in_enu_mps;
      }
    }
  }

  void SpeedsFromPositions(int begin, int end) {
    if (begin == end) return;
    for (int k = begin; k <= end; ++k) {
      const int a = std::max(begin, k - 1);
      const int b = std::min(end, k + 1);
      guess_.knots[Index(k)].velocity_in_enu_mps =
          (guess_.knots[Index(b)].position_in_enu_m - guess_.knots[Index(a)].position_in_enu_m) /
          (times_[Index(b)] - times_[Index(a)]);
    }
  }

  void Rotations(bool has_track) {
    if (!input_.attitudes.empty()) {
      for (std::size_t k = 0; k < times_.size(); ++k) {
        const Around<AttitudeFix> a = AroundTime(input_.attitudes, times_[k]);
        guess_.knots[k].enu_from_body =
            a.before->enu_from_body.slerp(a.weight, a.after->enu_from_body).normalized();
      }
      if (input_.attitudes.front().has_yaw || !has_track) return;
      const std::vector<double> headings = Headings();
      for (std::size_t k = 0; k < times_.size(); ++k) {
        Quaterniond& q = guess_.knots[k].enu_from_body;
        q = Turned(q, headings[k] - HeadingOfBody(q));
      }
      return;
    }
    if (has_track) {
      const std::vector<double> headings = Headings();
      for (std::size_t k = 0; k < times_.size(); ++k) guess_.knots[k].enu_from_body = LevelBody(headings[k]);
      return;
    }
    double heading = 0.0;
    for (const Marker& m : input_.markers) heading = m.yaw_rad.value_or(heading);
    guess_.knots.front().enu_from_body = still_rotation_.value_or(LevelBody(heading));
    reckon_rotation_ = true;
  }

  // Courses where the aircraft moves, carried over the rest by the gyro's yaw where there is one.
  std::vector<double> Headings() {
    const std::size_t n = times_.size();
    std::vector<double> turned(n, 0.0);
    problem_.ExpandAbout(guess_.knots);
    Quaterniond q = still_rotation_.value_or(LevelBody(0.0));
    for (std::size_t k = 0; k < n; ++k) {
      turned[k] = HeadingOfBody(q);
      const int i = static_cast<int>(k);
      if (k + 1 < n && problem_.HasImu(i)) {
        q = (q * Quaterniond(problem_.Imu(i).delta.CorrectedRotation(guess_.knots[k].gyro_bias_radps)))
                .normalized();
      }
    }
    // Offset of the course from the turned heading: sums over a window, so that a drifting gyro does no harm.
    constexpr double kWindowS = 15.0;
    std::vector<Eigen::Vector2d> sums(n + 1, Eigen::Vector2d::Zero());
    for (std::size_t k = 0; k < n; ++k) {
      const Vector3d& v = guess_.knots[k].velocity_in_enu_mps;
      sums[k + 1] = sums[k];
      if (v.head<2>().norm() < kCourseMinSpeedMps) continue;
      const double offset = HeadingOf(v) - turned[k];
      sums[k + 1] += Eigen::Vector2d(std::cos(offset), std::sin(offset));
    }
    std::vector<std::optional<double>> offsets(n);
    const bool has_gyro = problem_.ImuIntervals() > 0;
    const double window = has_gyro ? kWindowS : 0.1;
    std::size_t a = 0, b = 0;
    for (std::size_t k = 0; k < n; ++k) {
      while (times_[a] < times_[k] - window) ++a;
      while (b < n && times_[b] <= times_[k] + window) ++b;
      const Eigen::Vector2d sum = sums[b] - sums[a];
      if (sum.norm() > 0.5) offsets[k] = std::atan2(sum.y(), sum.x());
    }
    // Where nothing moved within the window: the nearest known offset, looking back first.
    std::optional<double> last;
    for (std::size_t k = 0; k < n; ++k) {
      if (offsets[k]) last = offsets[k];
      if (!offsets[k] && last) offsets[k] = last;
    }
    last.reset();
    for (std::size_t k = n; k-- > 0;) {
      if (offsets[k]) last = offsets[k];
      if (!offsets[k]) offsets[k] = last;
    }
    for (std::size_t k = 0; k < n; ++k) turned[k] += offsets[k].value_or(0.0);
    return turned;
  }

  std::optional<double> HeightAt(double t) const {
    if (input_.heights.empty()) return std::nullopt;
    const Around<HeightFix> h = AroundTime(input_.heights, t);
    return (1.0 - h.weight) * h.before->z_in_enu_m + h.weight * h.after->z_in_enu_m;
  }

  void DeadReckon(int from) {
    if (from == 0 && !input_.markers.empty())
      guess_.knots.front().position_in_enu_m = input_.markers.front().position_in_enu_m;
    for (int k = from; k + 1 < problem_.timeline().size(); ++k) {
      const KnotState& a = guess_.knots[Index(k)];
      KnotState& b = guess_.knots[Index(k) + 1];
      const double duration_s = problem_.timeline().Duration(k);
      const KnotState old = b;
      if (problem_.IsStill(k) && problem_.IsStill(k + 1)) {
        b = a;
        b.velocity_in_enu_mps.setZero();
      } else if (problem_.HasImu(k)) {
        b = problem_.Imu(k).delta.Predict(a, input_.options.gravity_mps2);
      } else {
        b = a;
        b.position_in_enu_m += duration_s * a.velocity_in_enu_mps;
      }
      if (!reckon_rotation_) b.enu_from_body = old.enu_from_body;
      if (const std::optional<double> z = HeightAt(times_[Index(k) + 1])) {
        b.velocity_in_enu_mps.z() = (*z - a.position_in_enu_m.z()) / duration_s;
        b.position_in_enu_m.z() = *z;
      }
    }
  }

  ChainProblem& problem_;
  const SmootherInput& input_;
  const std::vector<double>& times_;
  ChainGuess guess_;
  std::optional<Quaterniond> still_rotation_;
  bool reckon_rotation_ = false;
};

}  // namespace

ChainGuess GuessChain(ChainProblem& problem) { return Guesser(problem).Make(); }

}  // namespace skyquilt::poses
