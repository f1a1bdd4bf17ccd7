#include "core/simulate/sensors/recorded_pose.h"

#include <cmath>

#include "core/geo/geoid.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::simulate {
namespace {

struct Errors {
  double gnss_wander_m = 0.0, gnss_white_m = 0.0;      // each horizontal axis
  double height_wander_m = 0.0, height_white_m = 0.0;  // of the height above take-off
  double tilt_rad = 0.0, yaw_rad = 0.0, attitude_white_rad = 0.0;
  double focal = 0.0;  // relative
};

constexpr double kGnssCorrelationS = 120.0;
constexpr double kBaroCorrelationS = 300.0;
constexpr double kAttitudeCorrelationS = 40.0;

Errors ErrorsOf(NoiseClass noise) {
  if (noise == NoiseClass::kExact) return {};
  Errors errors{1.06, 0.15, 0.5, 0.1, geo::DegToRad(0.6), geo::DegToRad(1.5), geo::DegToRad(0.1), 0.01};
  if (noise == NoiseClass::kRtk) {
    errors.gnss_wander_m = 0.012;
    errors.gnss_white_m = 0.008;
    errors.height_wander_m = 0.02;
    errors.height_white_m = 0.012;
    errors.focal = 0.001;
  }
  return errors;
}

}  // namespace

std::vector<RecordedPose> RecordPoses(const std::vector<TruePose>& poses, const geo::LocalFrame& frame,
                                      const camera::Intrinsics& true_intrinsics, flight::UtcTime start,
                                      NoiseClass noise, const CameraClock& clock, std::uint32_t seed) {
  const Errors errors = ErrorsOf(noise);
  const bool has_position = noise != NoiseClass::kNoGps && noise != NoiseClass::kNoPose;
  const bool has_attitude = noise != NoiseClass::kNoAttitude && noise != NoiseClass::kNoPose;
  RandomStream random(seed, 201);
  GaussMarkov east(errors.gnss_wander_m, kGnssCorrelationS, random);
  GaussMarkov north(errors.gnss_wander_m, kGnssCorrelationS, random);
  GaussMarkov up(errors.height_wander_m, kBaroCorrelationS, random);
  GaussMarkov tilt_east(errors.tilt_rad, kAttitudeCorrelationS, random);
  GaussMarkov tilt_north(errors.tilt_rad, kAttitudeCorrelationS, random);
  GaussMarkov yaw(errors.yaw_rad, kAttitudeCorrelationS, random);
  const double focal_factor = 1.0 + (random.Uniform() < 0.5 ? -errors.focal : errors.focal);

  std::vector<RecordedPose> recorded;
  recorded.reserve(poses.size());
  double last_s = poses.empty() ? 0.0 : poses.front().t_s;
  for (const TruePose& pose : poses) {
    const double dt_s = pose.t_s - last_s;
    last_s = pose.t_s;
    RecordedPose out;
    out.intrinsics = true_intrinsics;
    out.intrinsics.focal_x_px *= focal_factor;
    out.intrinsics.focal_y_px *= focal_factor;
    out.is_lens_recorded = noise == NoiseClass::kExact || noise == NoiseClass::kRtk;
    if (!out.is_lens_recorded) {
      out.intrinsics = camera::Intrinsics::Centered(true_intrinsics.width_px, true_intrinsics.height_px,
                                                    out.intrinsics.MeanFocalPx());
    }

    // Every error is drawn for every photo, used or not: the classes of one seed share their noise.
    // Braces, because they fix the order of the draws.
    Eigen::Vector3d position_error{east.Step(dt_s, random), north.Step(dt_s, random), up.Step(dt_s, random)};
    position_error +=
        Eigen::Vector3d{errors.gnss_white_m * random.Gauss(), errors.gnss_white_m * random.Gauss(),
                        errors.height_white_m * random.Gauss()};
    Eigen::Vector3d turn_error{tilt_east.Step(dt_s, random), tilt_north.Step(dt_s, random),
                               yaw.Step(dt_s, random)};
    turn_error += errors.attitude_white_rad * Eigen::Vector3d{random.Gauss(), random.Gauss(), random.Gauss()};

    if (has_position) {
      out.position = frame.Wgs84FromEnu(pose.cam_from_enu.TargetOriginInSource() + position_error);
      out.height_above_takeoff_m = out.position->height_ellipsoid_m - frame.origin().height_ellipsoid_m;
      out.velocity_in_enu_mps = pose.velocity_in_enu_mps;
      out.is_rtk_fixed = noise == NoiseClass::kRtk;
    }
    if (has_attitude) {
      const Eigen::Quaterniond enu_from_cam =
          geo::RotationFromVector(turn_error) * pose.cam_from_enu.rotation.conjugate();
      out.gimbal = GimbalOfCamFromEnu(enu_from_cam.conjugate());
      out.airframe = YawPitchRoll{geo::WrapRad(pose.course_yaw_rad + turn_error.z()), 0.0, 0.0};
    }
    auto by_clock = std::chrono::microseconds(std::llround((pose.t_s + clock.offset_s) * 1e6));
    out.captured_at = start + by_clock;
    if (clock.is_local_seconds) {
      out.captured_at = std::chrono::floor<std::chrono::seconds>(out.captured_at);
      out.is_clock_utc = false;
    }
    recorded.push_back(out);
  }
  return recorded;
}

flight::Photo PhotoOfRecordedPose(const std::string& name, const RecordedPose& recorded) {
  flight::Photo photo;
  photo.name = name;
  photo.make = kCameraMake;
  photo.model = kCameraModel;
  photo.camera_key = kCameraModel;
  photo.intrinsics = recorded.intrinsics;
  photo.focal_source =
      recorded.is_lens_recorded ? flight::FocalSource::kDewarpData : flight::FocalSource::kCalibrated;
  photo.captured_at = recorded.captured_at;
  photo.captured_at_is_local = !recorded.is_clock_utc;
  if (recorded.position) {
    flight::RecordedPosition position;
    position.position = {recorded.position->lat_deg, recorded.position->lon_deg};
    position.height_above_takeoff_m = recorded.height_above_takeoff_m;
    if (recorded.is_rtk_fixed) {
      position.height_ellipsoid_m = recorded.position->height_ellipsoid_m;
      position.sigma_horizontal_m = 0.015;
      position.sigma_vertical_m = 0.025;
      position.is_rtk_fixed = true;
    } else if (const auto geoid_m = geo::GeoidHeightM(position.position)) {
      position.height_amsl_m = recorded.position->height_ellipsoid_m - *geoid_m;
    }
    position.source = "simulated";
    photo.position = position;
  }
  if (recorded.gimbal) {
    photo.attitude =
        flight::RecordedAttitude{flight::AttitudeKind::kGimbal, recorded.gimbal->yaw_rad,
                                 recorded.gimbal->pitch_rad, recorded.gimbal->roll_rad, "simulated"};
  }
  photo.velocity_in_enu_mps = recorded.velocity_in_enu_mps;
  photo.exposure_time_s = recorded.exposure_time_s;
  photo.exposure_log2 = std::log2(recorded.exposure_time_s) - 2.0 * std::log2(kFNumber);
  return photo;
}

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
