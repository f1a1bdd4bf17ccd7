#include "core/poses/smoother/chain_factors.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace skyquilt::poses {
namespace {

using Eigen::Vector3d;

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  Vector3d Vector(double scale) {
    return scale * Vector3d(normal_(random_), normal_(random_), normal_(random_));
  }
  KnotState Knot() {
    KnotState k;
    // Near level, nose anywhere, at some height above the ground.
    k.enu_from_body = Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265, Vector3d::UnitX())) *
                      Eigen::AngleAxisd(normal_(random_), Vector3d::UnitZ()) *
                      geo::RotationFromVector(Vector(0.2));
    k.velocity_in_enu_mps = Vector3d(4.0, 3.0, 0.0) + Vector(1.0);
    k.position_in_enu_m = Vector3d(10.0, -20.0, 60.0) + Vector(5.0);
    k.gyro_bias_radps = Vector(0.01);
    k.accel_bias_mps2 = Vector(0.1);
    k.gnss_bias_in_enu_m = Vector(1.0);
    k.attitude_bias_rad = Vector(0.1);
    k.baro_bias_m = normal_(random_);
    return k;
  }
  BorderState Border() {
    BorderState b;
    b.value.head<kBorderUsed>() =
        Eigen::Matrix<double, kBorderUsed, 1>::NullaryExpr([&] { return 0.2 * normal_(random_); });
    return b;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

template <int M>
using Factor = std::function<Linear<M>(const KnotState&, const KnotState&, const BorderState&)>;

// Central differences of the residual by every small step, against the Jacobians that the factor states.
template <int M>
void CheckJacobians(const char* name, const Factor<M>& factor) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const KnotState a = random.Knot();
    KnotState b = a.Moved(0.1 * Vector22::Random());
    b.position_in_enu_m += a.velocity_in_enu_mps;
    const BorderState border = random.Border();
    const Linear<M> stated = factor(a, b, border);
    const double scale =
        1.0 + std::max({stated.by_first.cwiseAbs().maxCoeff(), stated.by_second.cwiseAbs().maxCoeff(),
                        stated.by_border.cwiseAbs().maxCoeff()});
    constexpr double kStep = 1e-5;
    for (int i = 0; i < kStateSize; ++i) {
      const Vector22 step = kStep * Vector22::Unit(i);
      const auto slope = [&](const Linear<M>& plus, const Linear<M>& minus) {
        return ((plus.residual - minus.residual) / (2.0 * kStep)).eval();
      };
      EXPECT_LT((slope(factor(a.Moved(step), b, border), factor(a.Moved(-step), b, border)) -
                 stated.by_first.col(i))
                    .norm(),
                1e-6 * scale)
          << name << " first " << i;
      EXPECT_LT((slope(factor(a, b.Moved(step), border), factor(a, b.Moved(-step), border)) -
                 stated.by_second.col(i))
                    .norm(),
                1e-6 * scale)
          << name << " second " << i;
      BorderState plus = border, minus = border;
      plus.value += step;
      minus.value -= step;
      EXPECT_LT((slope(factor(a, b, plus), factor(a, b, minus)) - stated.by_border.col(i)).norm(),
                1e-6 * scale)
          << name << " border " << i;
    }
  }
}

Preintegration SomeImu() {
  std::vector<flight::ImuSample> samples;
  for (int k = 0; k <= 60; ++k) {
    const double t = 0.01 * k;
    samples.push_back(
        {t, Vector3d(0.3 * std::sin(5 * t), 0.2, -0.4 * t), Vector3d(1.0 + t, -0.5, -9.7 + std::cos(t))});
  }
  return *Preintegrate(samples, 0.05, 0.55, {0.3}, Vector3d(0.01, 0.0, 0.0), Vector3d::Zero(), ImuNoise{});
}

TEST(ChainFactors, StateTheirJacobians) {
  const Preintegration imu = SomeImu();
  const Matrix9d whiten = Matrix9d::Identity() * 3.0;
  CheckJacobians<9>("imu", [&](const auto& a, const auto& b, const auto&) {
    return ImuFactor(a, b, imu.delta, whiten, 9.81);
  });
  CheckJacobians<9>("motion prior", [](const auto& a, const auto& b, const auto&) {
    return MotionPriorFactor(a, b, 0.8, 1.0, 0.35);
  });
  BiasWalk walk;
  walk.gyro = 0.1;
  walk.accel = 0.2;
  walk.baro = 0.3;
  walk.gnss_keep = 0.9;
  CheckJacobians<13>("bias walk",
                     [&](const auto& a, const auto& b, const auto&) { return BiasWalkFactor(a, b, walk); });
  CheckJacobians<3>("still rotation",
                    [](const auto& a, const auto& b, const auto&) { return StillRotationFactor(a, b, 0.5); });
  CheckJacobians<3>("still",
                    [](const auto& a, const auto&, const auto&) { return StillVelocityFactor(a, 0.5); });
}

TEST(ChainFactors, StateTheirJacobiansAtTimesBetweenKnots) {
  const Preintegration imu = SomeImu();
  const auto check_all = [&](const auto& at) {
    // Velocity and position at a time depend on the acceleration, whose own change is of second order for the
    // lever and clock terms; they are checked with those held at zero, and the border's share at a knot.
    const auto none = [](BorderState border) {
      border.value.setZero();
      return border;
    };
    const Eigen::Quaterniond measured(Eigen::AngleAxisd(3.0, Vector3d(1.0, 0.1, 0.2).normalized()));
    CheckJacobians<3>("attitude", [&](const auto& a, const auto& b, const auto&) {
      return AttitudeFactor(at(a, b), measured, 0.1, 0.3);
    });
    CheckJacobians<2>("level",
                      [&](const auto& a, const auto& b, const auto&) { return LevelFactor(at(a, b), 0.1); });
    CheckJacobians<1>("course",
                      [&](const auto& a, const auto& b, const auto&) { return CourseFactor(at(a, b), 0.1); });
    CheckJacobians<1>("height", [&](const auto& a, const auto& b, const auto&) {
      return HeightFactor(at(a, b), 40.0, 0.2);
    });
    CheckJacobians<1>("range", [&](const auto& a, const auto& b, const auto&) {
      return RangeFactor(at(a, b), 60.0, 0.0, 1.0);
    });
    CheckJacobians<3>("marker", [&](const auto& a, const auto& b, const auto&) {
      return MarkerFactor(at(a, b), Vector3d(1, 2, 3), 0.5);
    });
    CheckJacobians<1>(
        "yaw", [&](const auto& a, const auto& b, const auto&) { return YawFactor(at(a, b), 0.3, 0.1); });
    const auto position = [&](const auto& a, const auto& b, const auto& border) {
      Linear<3> linear = PositionFactor(at(a, b), none(border), Vector3d(1, 2, 3), Vector3d(0.5, 0.5, 0.7));
      linear.by_border.setZero();
      return linear;
    };
    CheckJacobians<3>("gnss position", position);
    const auto velocity = [&](const auto& a, const auto& b, const auto& border) {
      Linear<3> linear = VelocityFactor(at(a, b), none(border), Vector3d(1, 2, 3), Vector3d(0.5, 0.5, 0.7));
      linear.by_border.setZero();
      return linear;
    };
    CheckJacobians<3>("gnss velocity", velocity);
  };
  check_all([](const KnotState& a, const KnotState&) { return StateAtKnot(a); });
  check_all(
      [&](const KnotState& a, const KnotState& b) { return StateByImu(a, b, 0.5, imu.at_cuts[0], 9.81); });
  check_all(
      [](const KnotState& a, const KnotState& b) { return StateByMotionPrior(a, b, 0.3, 0.9, 1.0, 0.35); });
}

TEST(ChainFactors, StateHowGnssDependsOnLeverArmAndClock) {
  const auto at = [](const KnotState& a) {
    StateBetween s = StateAtKnot(a);
    s.rate_radps = Vector3d(0.1, -0.2, 0.3);
    s.acceleration_mps2 = Vector3d(1.0, 0.5, -0.2);
    return s;
  };
  CheckJacobians<3>("gnss velocity", [&](const auto& a, const auto&, const auto& border) {
    return VelocityFactor(at(a), border, Vector3d(1, 2, 3), Vector3d(0.5, 0.5, 0.7));
  });
  CheckJacobians<3>("gnss position", [&](const auto& a, const auto&, const auto& border) {
    return PositionFactor(at(a), border, Vector3d(1, 2, 3), Vector3d(0.5, 0.5, 0.7));
  });
}

}  // namespace
}  // namespace skyquilt::poses
