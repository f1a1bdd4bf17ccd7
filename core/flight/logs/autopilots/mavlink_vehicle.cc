#include "core/flight/logs/autopilots/mavlink_vehicle.h"

#include <cmath>
#include <limits>

#include "core/base/median.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;

constexpr std::size_t kMaxVehicleEvents = 200'000;
constexpr std::uint64_t kByCamerasClock = 1;  // beside an event, where a Unix time may stand

bool IsUnixUs(std::uint64_t us) { return us > 946'684'800'000'000 && us < 4'102'444'800'000'000; }
UtcTime FromUnixUs(std::uint64_t us) {
  return UtcTime(std::chrono::microseconds(static_cast<std::int64_t>(us)));
}

}  // namespace

void MavlinkVehicle::Take(const MavlinkPacket& packet) {
  if (packet.system_id != system_) return;
  const LogBytes p = packet.payload;
  switch (packet.message_id) {
    case kSystemTime: {
      const auto unix_us = MavlinkField<std::uint64_t>(p, 0);
      const double t_s = Boot(packet, MavlinkField<std::uint32_t>(p, 8));
      if (IsUnixUs(unix_us)) vehicle_clock_.Add(t_s, FromUnixUs(unix_us));
      break;
    }
    case kAttitude:
      heading_rad_ = MavlinkField<float>(p, 12);
      ned_from_body_ = NedFromYawPitchRoll(MavlinkField<float>(p, 12), MavlinkField<float>(p, 8),
                                           MavlinkField<float>(p, 4));
      builder_.Add(AttitudeSample{Boot(packet, MavlinkField<std::uint32_t>(p, 0)), *ned_from_body_});
      break;
    case kGlobalPositionInt:
      TakeGlobalPosition(packet);
      break;
    case kGpsRawInt:
      TakeGps(packet);
      break;
    case kHighresImu:
      TakeImu(packet);
      break;
    case kDistanceSensor: {
      constexpr std::uint8_t kDown = 25;
      const double distance_m = MavlinkField<std::uint16_t>(p, 8) * 0.01;
      const double min_m = MavlinkField<std::uint16_t>(p, 4) * 0.01;
      const double max_m = MavlinkField<std::uint16_t>(p, 6) * 0.01;
      if (MavlinkField<std::uint8_t>(p, 12) == kDown && distance_m > min_m && distance_m < max_m) {
        builder_.Add(RangeSample{Boot(packet, MavlinkField<std::uint32_t>(p, 0)), distance_m});
      }
      break;
    }
    case kRangefinder: {
      const double distance_m = MavlinkField<float>(p, 0);
      if (distance_m > 0.0) builder_.Add(RangeSample{FromGround(packet), distance_m});
      break;
    }
    case kMountOrientation: {
      const double yaw_deg =
          p.size() > 16 ? MavlinkField<float>(p, 16) : std::numeric_limits<float>::quiet_NaN();
      has_mount_ = has_mount_ || std::isfinite(yaw_deg);
      builder_.AddGimbal({Boot(packet, MavlinkField<std::uint32_t>(p, 0)),
                          NedFromYawPitchRoll(DegToRad(yaw_deg), DegToRad(MavlinkField<float>(p, 8)),
                                              DegToRad(MavlinkField<float>(p, 4)))});
      break;
    }
    case kGimbalDeviceAttitudeStatus:
      TakeGimbal(packet);
      break;
    case kCameraFeedback:
      TakeFeedback(packet);
      break;
    case kCameraImageCaptured:
      TakeImageCaptured(packet);
      break;
    case kCameraTrigger: {
      CameraEvent event;
      event.is_feedback = false;
      event.sequence = MavlinkField<std::uint32_t>(p, 8);
      Keep(events_[2], event, packet, MavlinkField<std::uint64_t>(p, 0));
      break;
    }
    default:
      break;
  }
}

void MavlinkVehicle::Finish() {
  const auto vehicle = vehicle_clock_.Solve();
  const auto ground = ground_clock_.Solve();
  if (vehicle) {
    builder_.log().utc_at_zero = vehicle->utc_at_zero;
    builder_.log().utc_sigma_s = std::hypot(0.2, vehicle->scatter_s);
  } else if (ground) {
    builder_.log().utc_at_zero = ground->utc_at_zero;
    // Nobody checks a ground station's clock; internet time keeps it within seconds.
    builder_.log().utc_sigma_s = std::hypot(5.0, ground->scatter_s);
    builder_.Warn(RemarkCode::kClockOfGroundStation);
  }
  const double behind_s = CameraBehindS();
  if (CameraIsFixed()) {
    for (auto& [event, unix_us] : events_[1]) event.attitude_kind = AttitudeKind::kAirframe;
  }
  for (auto& list : events_) {  // the best kind that is there
    if (list.empty()) continue;
    for (auto& [event, unix_us] : list) {
      if (unix_us == kByCamerasClock) {
        event.t_s += behind_s;
      } else if (unix_us != 0 && builder_.log().utc_at_zero) {
        event.t_s = SecondsBetween(*builder_.log().utc_at_zero, FromUnixUs(unix_us));
      }
      builder_.Add(event);
    }
    break;
  }
}

double MavlinkVehicle::Boot(const MavlinkPacket& packet, std::uint32_t boot_ms) {
  const double t_s = boot_ms * 1e-3;
  ground_clock_.Add(t_s, FromUnixUs(packet.ground_unix_us));
  last_boot_s_ = t_s;
  last_ground_us_ = packet.ground_unix_us;
  return t_s;
}

double MavlinkVehicle::FromGround(const MavlinkPacket& packet) const {
  const auto since_us = static_cast<std::int64_t>(packet.ground_unix_us - last_ground_us_);
  return last_ground_us_ == 0 ? 0.0 : last_boot_s_ + static_cast<double>(since_us) * 1e-6;
}

double MavlinkVehicle::EitherClock(const MavlinkPacket& packet, std::uint64_t us) const {
  return us == 0 || IsUnixUs(us) ? FromGround(packet) : static_cast<double>(us) * 1e-6;
}

// Packets come within seconds. Those that are asked for later, one after the other, come at any distance from
// their times: these say nothing of the camera's clock.
double MavlinkVehicle::CameraBehindS() const {
  constexpr double kLatestPacketS = 5.0;
  const double late_s = MedianIfAny(image_late_s_).value_or(0.0);
  if (std::abs(late_s) <= kLatestPacketS) return 0.0;
  const double scatter_s = MedianOf(image_late_s_, [&](double one_s) { return std::abs(one_s - late_s); });
  return scatter_s <= kLatestPacketS ? late_s : 0.0;
}

void MavlinkVehicle::TakeGlobalPosition(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  const double t_s = Boot(packet, MavlinkField<std::uint32_t>(p, 0));
  builder_.Add(BaroSample{t_s, MavlinkField<std::int32_t>(p, 16) * 1e-3});
  if (has_gps_) return;
  GnssSample sample;
  sample.t_s = t_s;
  sample.position = {MavlinkField<std::int32_t>(p, 4) * 1e-7, MavlinkField<std::int32_t>(p, 8) * 1e-7};
  sample.height_amsl_m = MavlinkField<std::int32_t>(p, 12) * 1e-3;
  sample.velocity_in_ned_mps =
      Eigen::Vector3d(MavlinkField<std::int16_t>(p, 20), MavlinkField<std::int16_t>(p, 22),
                      MavlinkField<std::int16_t>(p, 24)) *
      0.01;
  builder_.Add(sample);
}

void MavlinkVehicle::TakeGps(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  const auto fix = MavlinkField<std::uint8_t>(p, 28);
  if (fix < 3) return;
  GnssSample sample;
  sample.t_s = EitherClock(packet, MavlinkField<std::uint64_t>(p, 0));
  sample.position = {MavlinkField<std::int32_t>(p, 8) * 1e-7, MavlinkField<std::int32_t>(p, 12) * 1e-7};
  sample.height_amsl_m = MavlinkField<std::int32_t>(p, 16) * 1e-3;
  sample.is_rtk_fixed = fix == 6;
  if (p.size() > 30) {  // extensions of protocol 2
    const auto ellipsoid_mm = MavlinkField<std::int32_t>(p, 30);
    const auto horizontal_mm = MavlinkField<std::uint32_t>(p, 34);
    const auto vertical_mm = MavlinkField<std::uint32_t>(p, 38);
    if (ellipsoid_mm != 0) sample.height_ellipsoid_m = ellipsoid_mm * 1e-3;
    if (horizontal_mm != 0) sample.sigma_horizontal_m = horizontal_mm * 1e-3;
    if (vertical_mm != 0) sample.sigma_vertical_m = vertical_mm * 1e-3;
  }
  builder_.Add(sample);
}

void MavlinkVehicle::TakeImu(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  ImuSample sample;
  sample.t_s = EitherClock(packet, MavlinkField<std::uint64_t>(p, 0));
  for (std::size_t i = 0; i < 3; ++i) {
    sample.specific_force_mps2[static_cast<Eigen::Index>(i)] = MavlinkField<float>(p, 8 + 4 * i);
    sample.angular_rate_radps[static_cast<Eigen::Index>(i)] = MavlinkField<float>(p, 20 + 4 * i);
  }
  builder_.Add(sample);
}

void MavlinkVehicle::TakeGimbal(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  const auto id = MavlinkField<std::uint8_t>(p, 48);
  if (!gimbal_) gimbal_ = id;
  if (*gimbal_ != id || has_mount_ || last_ground_us_ == 0) return;
  const Eigen::Quaterniond q(MavlinkField<float>(p, 4), MavlinkField<float>(p, 8), MavlinkField<float>(p, 12),
                             MavlinkField<float>(p, 16));
  const auto ned_from_gimbal = NedFromGimbalDevice(q, MavlinkField<std::uint16_t>(p, 36), heading_rad_);
  // The gimbal may count from its own start.
  if (ned_from_gimbal) builder_.AddGimbal({FromGround(packet), *ned_from_gimbal});
}

void MavlinkVehicle::TakeFeedback(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  CameraEvent event;
  event.position =
      geo::LatLon{MavlinkField<std::int32_t>(p, 8) * 1e-7, MavlinkField<std::int32_t>(p, 12) * 1e-7};
  event.height_amsl_m = MavlinkField<float>(p, 16);
  event.height_above_takeoff_m = MavlinkField<float>(p, 20);
  event.yaw_pitch_roll_rad =
      Eigen::Vector3d(DegToRad(MavlinkField<float>(p, 32)), DegToRad(MavlinkField<float>(p, 28)),
                      DegToRad(MavlinkField<float>(p, 24)));
  event.sequence = MavlinkField<std::uint16_t>(p, 40);
  constexpr std::uint8_t kOpenLoop = 4;  // CAMERA_FEEDBACK_FLAGS: the time is guessed from the command
  event.is_feedback = MavlinkField<std::uint8_t>(p, 44) != kOpenLoop;
  Keep(events_[0], event, packet, MavlinkField<std::uint64_t>(p, 0));
}

// Of all photos at once: in a turn the vehicle's latest attitude may be an old one, and a gimbal may look to
// the horizon now and then.
bool MavlinkVehicle::CameraIsFixed() const {
  constexpr double kSameDeg = 10.0;
  const auto apart_rad = MedianIfAny(image_off_body_rad_);
  return apart_rad && *apart_rad < DegToRad(kSameDeg);
}

void MavlinkVehicle::TakeImageCaptured(const MavlinkPacket& packet) {
  const LogBytes p = packet.payload;
  if (MavlinkField<std::int8_t>(p, 49) == 0) return;  // capture_result: failed
  CameraEvent event;
  event.t_s = MavlinkField<std::uint32_t>(p, 8) * 1e-3;
  event.position =
      geo::LatLon{MavlinkField<std::int32_t>(p, 12) * 1e-7, MavlinkField<std::int32_t>(p, 16) * 1e-7};
  event.height_amsl_m = MavlinkField<std::int32_t>(p, 20) * 1e-3;
  constexpr std::int32_t kNotKnownMm = -1000;  // as PX4 writes it
  if (const auto above_mm = MavlinkField<std::int32_t>(p, 24); above_mm != kNotKnownMm)
    event.height_above_takeoff_m = above_mm * 1e-3;
  const Eigen::Quaterniond q(MavlinkField<float>(p, 28), MavlinkField<float>(p, 32),
                             MavlinkField<float>(p, 36), MavlinkField<float>(p, 40));
  if (q.coeffs().allFinite() && q.norm() > 0.5) {
    event.yaw_pitch_roll_rad = YawPitchRollFromNed(q);
    event.attitude_kind = AttitudeKind::kGimbal;
  }
  event.sequence = MavlinkField<std::int32_t>(p, 44);
  if (events_[1].size() >= kMaxVehicleEvents) return;
  if (event.yaw_pitch_roll_rad && ned_from_body_ && ned_from_body_->coeffs().allFinite())
    image_off_body_rad_.push_back(ned_from_body_->angularDistance(q));
  if (event.t_s > 0.0) {
    if (last_ground_us_ != 0) image_late_s_.push_back(FromGround(packet) - event.t_s);
    events_[1].emplace_back(event, kByCamerasClock);
  } else {
    Keep(events_[1], event, packet, MavlinkField<std::uint64_t>(p, 0));
  }
}

void MavlinkVehicle::Keep(Events& list, CameraEvent event, const MavlinkPacket& packet, std::uint64_t us) {
  if (list.size() >= kMaxVehicleEvents) return;
  event.t_s = EitherClock(packet, us);
  list.emplace_back(std::move(event), IsUnixUs(us) ? us : 0);
}

}  // namespace skyquilt::flight
