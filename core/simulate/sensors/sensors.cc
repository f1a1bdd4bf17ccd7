#include "core/simulate/sensors/sensors.h"

#include <algorithm>
#include <cmath>

#include "core/geo/geoid.h"
#include "core/geo/rigid3.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {

ImuModel IcmClassImu() { return {}; }

ImuModel MpuClassImu() {
  ImuModel imu;
  imu.gyro_white = 8.7e-5;
  imu.accel_white = 3.9e-3;
  imu.gyro_turn_on = 0.0087;
  imu.accel_turn_on = 0.049;
  imu.accel_walk = 1.0e-3;
  return imu;
}

ImuModel WithDefects(ImuModel imu, double vibration_mps2) {
  imu.scale = 0.005;
  imu.misalignment_rad = 0.0087;
  imu.vibration_mps2 = vibration_mps2;
  imu.gyro_step_radps = 0.00107;  // 2000 deg/s over 16 bits
  imu.accel_step_mps2 = 0.0048;   // 16 g over 16 bits
  imu.lost_share = 0.01;
  imu.time_jitter_s = 0.001;
  return imu;
}

GnssModel RtkGnss() {
  GnssModel gnss;
  gnss.is_rtk = true;
  gnss.wander_horizontal_m = 0.01;
  gnss.wander_vertical_m = 0.02;
  gnss.white_horizontal_m = 0.008;
  gnss.white_vertical_m = 0.012;
  return gnss;
}

namespace {

bool IsInside(double t_s, const std::vector<std::pair<double, double>>& spans_s) {
  return std::any_of(spans_s.begin(), spans_s.end(),
                     [t_s](const auto& span) { return t_s >= span.first && t_s < span.second; });
}

Eigen::Vector3d Gauss3(double sigma, RandomStream& random) {
  return {sigma * random.Gauss(), sigma * random.Gauss(), sigma * random.Gauss()};
}

Eigen::Vector3d Quantised(const Eigen::Vector3d& v, double step) {
  return step > 0.0 ? Eigen::Vector3d((v / step).array().round() * step) : v;
}

// One triad of axes: bias that walks, scale, misalignment, white noise.
class Triad {
 public:
  Triad(double turn_on, double walk, double white, double scale, double misalignment, RandomStream& random)
      : walk_(walk), white_(white), bias_(Gauss3(turn_on, random)) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const double off = (row == column ? scale : misalignment) * random.Gauss();
        shape_(row, column) = (row == column ? 1.0 : 0.0) + off;
      }
    }
  }
  Eigen::Vector3d Measure(const Eigen::Vector3d& truth, double interval_s, RandomStream& random) {
    bias_ += Gauss3(walk_ * std::sqrt(interval_s), random);
    return shape_ * truth + bias_ + Gauss3(white_ / std::sqrt(interval_s), random);
  }

 private:
  double walk_, white_;
  Eigen::Vector3d bias_;
  Eigen::Matrix3d shape_;
};

void SenseImu(const FlightPath& path, const ImuModel& model, std::uint32_t seed, flight::FlightLog& log) {
  RandomStream random(seed, 501);
  Triad gyro(model.gyro_turn_on, model.gyro_walk, model.gyro_white, model.scale, model.misalignment_rad,
             random);
  Triad accel(model.accel_turn_on, model.accel_walk, model.accel_white, model.scale, model.misalignment_rad,
              random);
  const double interval_s = 1.0 / model.rate_hz;
  std::vector<double> phases;
  for (std::size_t i = 0; i < model.vibration_hz.size(); ++i)
    phases.push_back(random.Uniform(0.0, 2.0 * geo::kPi));
  double last_s = -1.0;
  for (double begin_s = 0.0; begin_s + interval_s <= path.EndS(); begin_s += interval_s) {
    flight::ImuSample sample;
    path.MeanInertial(begin_s, begin_s + interval_s, sample.angular_rate_radps, sample.specific_force_mps2);
    const double middle_s = begin_s + 0.5 * interval_s;
    if (model.vibration_mps2 > 0.0 && path.At(middle_s).velocity_in_enu_mps.squaredNorm() > 1e-6) {
      for (std::size_t i = 0; i < phases.size(); ++i) {
        const double wave = std::sin(2.0 * geo::kPi * model.vibration_hz[i] * middle_s + phases[i]);
        sample.specific_force_mps2 += model.vibration_mps2 * wave * Eigen::Vector3d(0.6, 0.5, 1.0);
        sample.angular_rate_radps += 0.02 * model.vibration_mps2 * wave * Eigen::Vector3d(1.0, -0.8, 0.3);
      }
    }
    sample.angular_rate_radps =
        Quantised(gyro.Measure(sample.angular_rate_radps, interval_s, random), model.gyro_step_radps);
    sample.specific_force_mps2 =
        Quantised(accel.Measure(sample.specific_force_mps2, interval_s, random), model.accel_step_mps2);
    sample.t_s = middle_s + model.time_jitter_s * random.Uniform(-1.0, 1.0);
    const bool is_lost = random.Uniform() < model.lost_share;
    if (is_lost || IsInside(middle_s, model.gaps_s) || sample.t_s <= last_s) continue;
    last_s = sample.t_s;
    log.imu.push_back(sample);
  }
}

void SenseGnss(const FlightPath& path, const geo::LocalFrame& frame, const GnssModel& model,
               std::uint32_t seed, flight::FlightLog& log) {
  RandomStream random(seed, 502);
  GaussMarkov east(model.wander_horizontal_m, model.wander_correlation_s, random);
  GaussMarkov north(model.wander_horizontal_m, model.wander_correlation_s, random);
  GaussMarkov up(model.wander_vertical_m, model.wander_correlation_s, random);
  GaussMarkov float_east(0.3, 30.0, random);
  GaussMarkov float_north(0.3, 30.0, random);
  const double interval_s = 1.0 / model.rate_hz;
  for (double t_s = model.latency_s; t_s <= path.EndS(); t_s += interval_s) {
    const double described_s = t_s - model.latency_s;
    const PathState truth = path.At(described_s);
    Eigen::Vector3d error{east.Step(interval_s, random), north.Step(interval_s, random),
                          up.Step(interval_s, random)};
    error +=
        Eigen::Vector3d{model.white_horizontal_m * random.Gauss(), model.white_horizontal_m * random.Gauss(),
                        model.white_vertical_m * random.Gauss()};
    const Eigen::Vector3d velocity_error{model.velocity_horizontal_mps * random.Gauss(),
                                         model.velocity_horizontal_mps * random.Gauss(),
                                         model.velocity_vertical_mps * random.Gauss()};
    const Eigen::Vector3d float_error{float_east.Step(interval_s, random),
                                      float_north.Step(interval_s, random), 0.0};
    const bool is_float = model.is_rtk && IsInside(described_s, model.rtk_float_s);
    if (is_float) error += float_error;
    if (IsInside(described_s, model.outages_s)) continue;
    const geo::Wgs84 at = frame.Wgs84FromEnu(truth.point_in_enu + error);
    const Eigen::Vector3d velocity = truth.velocity_in_enu_mps + velocity_error;
    flight::GnssSample sample;
    sample.t_s = t_s;
    sample.position = {at.lat_deg, at.lon_deg};
    sample.height_ellipsoid_m = at.height_ellipsoid_m;
    if (const auto geoid_m = geo::GeoidHeightM(sample.position))
      sample.height_amsl_m = at.height_ellipsoid_m - *geoid_m;
    sample.velocity_in_ned_mps = Eigen::Vector3d(velocity.y(), velocity.x(), -velocity.z());
    sample.sigma_horizontal_m =
        is_float ? 0.42 : std::hypot(model.wander_horizontal_m, model.white_horizontal_m);
    sample.sigma_vertical_m = is_float ? 0.6 : std::hypot(model.wander_vertical_m, model.white_vertical_m);
    sample.is_rtk_fixed = model.is_rtk && !is_float;
    log.gnss.push_back(sample);
  }
}

void SenseAttitude(const FlightPath& path, const AttitudeModel& model, std::uint32_t seed,
                   flight::FlightLog& log) {
  RandomStream random(seed, 503);
  GaussMarkov roll(model.tilt_rad, model.correlation_s, random);
  GaussMarkov pitch(model.tilt_rad, model.correlation_s, random);
  GaussMarkov yaw(model.yaw_rad, model.correlation_s, random);
  const double interval_s = 1.0 / model.rate_hz;
  for (double t_s = 0.0; t_s <= path.EndS(); t_s += interval_s) {
    Eigen::Vector3d error{roll.Step(interval_s, random), pitch.Step(interval_s, random),
                          yaw.Step(interval_s, random)};
    error += Gauss3(model.white_rad, random);
    flight::AttitudeSample sample;
    sample.t_s = t_s;
    // The error turns about the NED axes: the tilt's and the heading's.
    sample.ned_from_body =
        (geo::RotationFromVector(error) * NedFromBody(path.At(t_s).enu_from_body)).normalized();
    log.attitude.push_back(sample);
  }
}

void SenseBaro(const FlightPath& path, const BaroModel& model, std::uint32_t seed, flight::FlightLog& log) {
  RandomStream random(seed, 504);
  GaussMarkov drift(model.drift_m, model.correlation_s, random);
  const double at_takeoff_m = drift.value();
  const double interval_s = 1.0 / model.rate_hz;
  for (double t_s = 0.0; t_s <= path.EndS(); t_s += interval_s) {
    const double error_m = drift.Step(interval_s, random) - at_takeoff_m + model.white_m * random.Gauss();
    log.baro.push_back({t_s, path.At(t_s).point_in_enu.z() + error_m});
  }
}

void SenseRange(const FlightPath& path, const RangeModel& model, std::uint32_t seed, flight::FlightLog& log) {
  RandomStream random(seed, 505);
  const double interval_s = 1.0 / model.rate_hz;
  for (double t_s = 0.0; t_s <= path.EndS(); t_s += interval_s) {
    const PathState state = path.At(t_s);
    const double white = random.Gauss();
    const Eigen::Vector3d beam = state.enu_from_body * Eigen::Vector3d::UnitZ();
    if (beam.z() > -0.1) continue;
    const double distance_m = state.point_in_enu.z() / -beam.z();
    if (distance_m > model.farthest_m) continue;
    const double measured_m = distance_m + std::hypot(model.white_m, model.relative * distance_m) * white;
    if (measured_m >= model.nearest_m) log.range.push_back({t_s, measured_m});
  }
}

void SenseExposures(const std::vector<double>& exposures_s, const CameraEventModel& model, std::uint32_t seed,
                    flight::FlightLog& log) {
  RandomStream random(seed, 506);
  std::int64_t sequence = 0;
  for (const double exposure_s : exposures_s) {
    const double delay_s = std::max(0.0, model.delay_s + model.delay_jitter_s * random.Gauss());
    const double feedback_s = exposure_s + model.feedback_jitter_s * random.Gauss();
    const bool is_lost = random.Uniform() < model.lost_share;
    const bool is_doubled = random.Uniform() < model.doubled_share;
    flight::CameraEvent event;
    event.is_feedback = model.has_feedback;
    event.t_s = model.has_feedback ? feedback_s : exposure_s - delay_s;
    event.sequence = ++sequence;
    if (is_lost) continue;
    log.events.push_back(event);
    if (!is_doubled) continue;
    event.t_s += 0.02;
    event.sequence = ++sequence;
    log.events.push_back(event);
  }
  std::stable_sort(log.events.begin(), log.events.end(),
                   [](const auto& a, const auto& b) { return a.t_s < b.t_s; });
}

}  // namespace

flight::FlightLog SenseFlight(const FlightPath& path, const geo::LocalFrame& frame,
                              const std::vector<double>& exposures_s, flight::UtcTime utc_at_zero,
                              const SensorOptions& options) {
  flight::FlightLog log;
  log.format = "simulated";
  log.utc_at_zero = utc_at_zero;
  if (options.has_imu) SenseImu(path, options.imu, options.seed, log);
  if (options.has_gnss) SenseGnss(path, frame, options.gnss, options.seed, log);
  if (options.has_attitude) SenseAttitude(path, options.attitude, options.seed, log);
  if (options.has_baro) SenseBaro(path, options.baro, options.seed, log);
  if (options.has_range) SenseRange(path, options.range, options.seed, log);
  SenseExposures(exposures_s, options.events, options.seed, log);
  return log;
}

}  // namespace skyquilt::simulate
