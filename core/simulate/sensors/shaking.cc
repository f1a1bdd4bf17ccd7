#include "core/simulate/sensors/shaking.h"

#include <cmath>

#include "core/geo/lat_lon.h"

namespace skyquilt::simulate {
namespace {

struct Band {
  double low_hz, high_hz, share;  // of the rate's variance
};
constexpr Band kBands[] = {{1.0, 4.0, 0.85}, {8.0, 15.0, 0.13}, {30.0, 60.0, 0.02}};
constexpr double kMarginS = 0.010;
constexpr double kSampleS = 0.001;
constexpr double kIntegrationS = 0.00025;
constexpr int kKnots = 257;

}  // namespace

Shaking::Shaking(double rate_radps, RandomStream& random) {
  for (const Band& band : kBands) {
    const double turns_per_s = random.Uniform(band.low_hz, band.high_hz);
    // Sine and cosine with normal factors: the rate at any moment has the variance of either.
    const double sigma = rate_radps * std::sqrt(band.share);
    Wave wave{.sine_radps = {}, .cosine_radps = {}, .turns_per_s = turns_per_s};
    for (int axis = 0; axis < 3; ++axis) wave.sine_radps[axis] = sigma * random.Gauss();
    for (int axis = 0; axis < 3; ++axis) wave.cosine_radps[axis] = sigma * random.Gauss();
    waves_.push_back(wave);
  }
}

Eigen::Vector3d Shaking::RateInCam(double time_s) const {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();
  for (const Wave& wave : waves_) {
    const double angle = 2.0 * geo::kPi * wave.turns_per_s * time_s;
    rate += std::sin(angle) * wave.sine_radps + std::cos(angle) * wave.cosine_radps;
  }
  return rate;
}

std::vector<Eigen::Vector3d> Shaking::TurnsOfRows(double readout_s, double exposure_s) const {
  // Orientations in steps much finer than the rows' knots, from the first knot on.
  std::vector<Eigen::Quaterniond> first_from_knot{Eigen::Quaterniond::Identity()};
  const double knot_s = readout_s / (kKnots - 1);
  const int steps = static_cast<int>(std::ceil(knot_s / kIntegrationS));
  for (int k = 1; k < kKnots; ++k) {
    Eigen::Quaterniond turned = first_from_knot.back();
    for (int step = 0; step < steps; ++step) {
      const double time_s = 0.5 * exposure_s + (k - 1 + (step + 0.5) / steps) * knot_s;
      turned = turned * geo::RotationFromVector(knot_s / steps * RateInCam(time_s));
    }
    first_from_knot.push_back(turned.normalized());
  }
  std::vector<Eigen::Vector3d> turns_rad;
  for (const Eigen::Quaterniond& of_row : first_from_knot) {
    turns_rad.push_back(
        geo::VectorFromRotation((of_row.conjugate() * first_from_knot[kKnots / 2]).normalized()));
  }
  return turns_rad;
}

flight::RecordedTurning RecordShaking(const Shaking& shaking, double readout_s, const GyroModel& model,
                                      RandomStream& random) {
  flight::RecordedTurning turning;
  Eigen::Vector3d bias;
  for (int axis = 0; axis < 3; ++axis) bias[axis] = model.bias_radps * random.Gauss();
  const int count = static_cast<int>((readout_s + 2.0 * kMarginS) / kSampleS) + 1;
  for (int i = 0; i < count; ++i) {
    const double time_s = i * kSampleS - kMarginS;
    Eigen::Vector3d rate = shaking.RateInCam(time_s - kGyroLagS) + bias;
    for (int axis = 0; axis < 3; ++axis) rate[axis] += model.noise_radps * random.Gauss();
    turning.samples.push_back({time_s, rate});
  }
  return turning;
}

}  // namespace skyquilt::simulate
