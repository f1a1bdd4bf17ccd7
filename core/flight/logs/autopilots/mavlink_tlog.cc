#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/autopilots/mavlink_packet.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {
namespace {

// Messages that are counted apart; vehicles send some hundred kinds. The others count as kOtherMavlink.
constexpr std::size_t kMaxMavlinkKinds = 1000;
constexpr std::uint32_t kOtherMavlink = 0xFFFFFFFF;  // numbers have 24 bits

// Walks the packets; after damage goes on at the next place where two packets follow one another.
struct MavlinkWalk {
  std::map<std::uint32_t, std::uint64_t> counts;
  std::uint64_t packets = 0;
  std::uint64_t damaged_bytes = 0;
  bool cut = false;

  template <typename OnPacket>
  void Run(LogBytes bytes, const ConsumedUpTo& consumed, const OnPacket& on_packet) {
    std::size_t at = 0;
    ConsumedSteps steps(consumed);
    MavlinkPacket packet;
    bool in_step = true;
    while (at < bytes.size()) {
      steps.At(at);
      const MavlinkFrame frame = ReadMavlinkPacket(bytes, at, packet);
      if (frame == MavlinkFrame::kPacket &&
          (in_step || packet.checksum_known || FollowedByPacket(bytes, at + packet.size))) {
        in_step = true;
        ++packets;
        ++CountOf(packet.message_id);
        on_packet(packet);
        at += packet.size;
        continue;
      }
      if (frame == MavlinkFrame::kCut && in_step) {
        cut = true;
        return;
      }
      in_step = false;
      ++damaged_bytes;
      ++at;
    }
  }

 private:
  static bool FollowedByPacket(LogBytes bytes, std::size_t at) {
    MavlinkPacket next;
    return at == bytes.size() || ReadMavlinkPacket(bytes, at, next) == MavlinkFrame::kPacket;
  }
  std::uint64_t& CountOf(std::uint32_t id) {
    if (id != last_id_ || last_count_ == nullptr) {
      last_id_ = id;
      const bool has_room = counts.size() < kMaxMavlinkKinds || counts.contains(id);
      last_count_ = &counts[has_room ? id : kOtherMavlink];
    }
    return *last_count_;
  }
  std::uint32_t last_id_ = 0;
  std::uint64_t* last_count_ = nullptr;
};

enum MavlinkMessageId : std::uint32_t {
  kSystemTime = 2,
  kGpsRawInt = 24,
  kRawImu = 27,
  kAttitude = 30,
  kGlobalPositionInt = 33,
  kHighresImu = 105,
  kCameraTrigger = 112,
  kDistanceSensor = 132,
  kRangefinder = 173,
  kCameraFeedback = 180,
  kCameraImageCaptured = 263,
  kMountOrientation = 265,
  kGimbalDeviceAttitudeStatus = 285,
};

using geo::DegToRad;

constexpr std::size_t kMaxVehicleEvents = 200'000;

bool IsUnixUs(std::uint64_t us) { return us > 946'684'800'000'000 && us < 4'102'444'800'000'000; }
UtcTime FromUnixUs(std::uint64_t us) {
  return UtcTime(std::chrono::microseconds(static_cast<std::int64_t>(us)));
}

// What one vehicle sent, packet by packet, as samples of a LogBuilder. Messages without a time of the vehicle
// are placed by the ground station's clock.
class MavlinkVehicle {
 public:
  // `has_gps`: raw fixes are among the packets: the autopilot's own solution is not taken beside them.
  MavlinkVehicle(LogBuilder& builder, std::uint8_t system_id, bool has_gps)
      : builder_(builder), system_(system_id), has_gps_(has_gps) {}

  // Packets of other vehicles are passed over.
  void Take(const MavlinkPacket& packet) {
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
        builder_.Add(AttitudeSample{Boot(packet, MavlinkField<std::uint32_t>(p, 0)),
                                    NedFromYawPitchRoll(MavlinkField<float>(p, 12), MavlinkField<float>(p, 8),
                                                        MavlinkField<float>(p, 4))});
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

  // Sets the log's clock and hands on the camera events, which need it.
  void Finish() {
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
    for (auto& list : events_) {  // the best kind that is there
      if (list.empty()) continue;
      for (auto& [event, unix_us] : list) {
        if (unix_us != 0 && builder_.log().utc_at_zero) {
          event.t_s = SecondsBetween(*builder_.log().utc_at_zero, FromUnixUs(unix_us));
        }
        builder_.Add(event);
      }
      break;
    }
  }

 private:
  // With a Unix time to be placed at the end, or 0.
  using Events = std::vector<std::pair<CameraEvent, std::uint64_t>>;

  // The vehicle's clock, noting how the ground station's runs against it.
  double Boot(const MavlinkPacket& packet, std::uint32_t boot_ms) {
    const double t_s = boot_ms * 1e-3;
    ground_clock_.Add(t_s, FromUnixUs(packet.ground_unix_us));
    last_boot_s_ = t_s;
    last_ground_us_ = packet.ground_unix_us;
    return t_s;
  }

  // For messages without a time of the vehicle: what its clock must be about now.
  double FromGround(const MavlinkPacket& packet) const {
    const auto since_us = static_cast<std::int64_t>(packet.ground_unix_us - last_ground_us_);
    return last_ground_us_ == 0 ? 0.0 : last_boot_s_ + static_cast<double>(since_us) * 1e-6;
  }

  // Fields named time_usec hold the time since boot or Unix time, at the sender's choice.
  double EitherClock(const MavlinkPacket& packet, std::uint64_t us) const {
    return us == 0 || IsUnixUs(us) ? FromGround(packet) : static_cast<double>(us) * 1e-6;
  }

  void TakeGlobalPosition(const MavlinkPacket& packet) {
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

  void TakeGps(const MavlinkPacket& packet) {
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

  void TakeImu(const MavlinkPacket& packet) {
    const LogBytes p = packet.payload;
    ImuSample sample;
    sample.t_s = EitherClock(packet, MavlinkField<std::uint64_t>(p, 0));
    for (std::size_t i = 0; i < 3; ++i) {
      sample.specific_force_mps2[static_cast<Eigen::Index>(i)] = MavlinkField<float>(p, 8 + 4 * i);
      sample.angular_rate_radps[static_cast<Eigen::Index>(i)] = MavlinkField<float>(p, 20 + 4 * i);
    }
    builder_.Add(sample);
  }

  void TakeGimbal(const MavlinkPacket& packet) {
    const LogBytes p = packet.payload;
    const auto id = MavlinkField<std::uint8_t>(p, 48);
    if (!gimbal_) gimbal_ = id;
    if (*gimbal_ != id || has_mount_ || last_ground_us_ == 0) return;
    const Eigen::Quaterniond q(MavlinkField<float>(p, 4), MavlinkField<float>(p, 8),
                               MavlinkField<float>(p, 12), MavlinkField<float>(p, 16));
    const auto ned_from_gimbal = NedFromGimbalDevice(q, MavlinkField<std::uint16_t>(p, 36), heading_rad_);
    // The gimbal may count from its own start.
    if (ned_from_gimbal) builder_.AddGimbal({FromGround(packet), *ned_from_gimbal});
  }

  void TakeFeedback(const MavlinkPacket& packet) {
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

  void TakeImageCaptured(const MavlinkPacket& packet) {
    const LogBytes p = packet.payload;
    if (MavlinkField<std::int8_t>(p, 49) == 0) return;  // capture_result: failed
    CameraEvent event;
    event.t_s = MavlinkField<std::uint32_t>(p, 8) * 1e-3;
    event.position =
        geo::LatLon{MavlinkField<std::int32_t>(p, 12) * 1e-7, MavlinkField<std::int32_t>(p, 16) * 1e-7};
    event.height_amsl_m = MavlinkField<std::int32_t>(p, 20) * 1e-3;
    event.height_above_takeoff_m = MavlinkField<std::int32_t>(p, 24) * 1e-3;
    const Eigen::Quaterniond q(MavlinkField<float>(p, 28), MavlinkField<float>(p, 32),
                               MavlinkField<float>(p, 36), MavlinkField<float>(p, 40));
    if (q.coeffs().allFinite() && q.norm() > 0.5) {
      event.yaw_pitch_roll_rad = YawPitchRollFromNed(q);
      event.attitude_kind = AttitudeKind::kGimbal;
    }
    event.sequence = MavlinkField<std::int32_t>(p, 44);
    if (event.t_s > 0.0) {
      if (events_[1].size() < kMaxVehicleEvents) events_[1].emplace_back(event, 0);
    } else {
      Keep(events_[1], event, packet, MavlinkField<std::uint64_t>(p, 0));
    }
  }

  void Keep(Events& list, CameraEvent event, const MavlinkPacket& packet, std::uint64_t us) {
    if (list.size() >= kMaxVehicleEvents) return;
    event.t_s = EitherClock(packet, us);
    list.emplace_back(std::move(event), IsUnixUs(us) ? us : 0);
  }

  LogBuilder& builder_;
  std::uint8_t system_;
  bool has_gps_;
  ClockPairs vehicle_clock_;
  ClockPairs ground_clock_;
  double last_boot_s_ = 0.0;
  std::uint64_t last_ground_us_ = 0;
  std::optional<double> heading_rad_;
  std::optional<std::uint8_t> gimbal_;  // the first of them
  bool has_mount_ = false;              // whose orientation counts by the vehicle's clock
  Events events_[3];                    // the best kind first
};

}  // namespace

bool LooksLikeMavlinkTlog(LogBytes head) {
  MavlinkPacket first;
  if (ReadMavlinkPacket(head, 0, first) != MavlinkFrame::kPacket) return false;
  MavlinkPacket second;
  if (first.checksum_known && first.size >= head.size()) return true;
  return ReadMavlinkPacket(head, first.size, second) == MavlinkFrame::kPacket;
}

Result<FlightLog> ParseMavlinkTlog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("mavlink_tlog", name);
  std::map<std::uint8_t, std::uint64_t> attitudes;
  std::map<std::uint8_t, std::uint64_t> fixes;
  MavlinkWalk walk;
  walk.Run(bytes, consumed, [&](const MavlinkPacket& packet) {
    if (packet.message_id == kAttitude) attitudes[packet.system_id] += 2;
    if (packet.message_id == kGpsRawInt && MavlinkField<std::uint8_t>(packet.payload, 28) >= 3) {
      ++fixes[packet.system_id];
      ++attitudes[packet.system_id];
    }
    if (packet.message_id == kGlobalPositionInt || packet.message_id == kCameraFeedback)
      ++attitudes[packet.system_id];
  });
  if (walk.packets == 0) return builder.Refuse(RemarkCode::kTlogEmpty);
  for (const auto& [id, count] : walk.counts) builder.Count(MavlinkMessageName(id), count);
  if (walk.damaged_bytes > 0) builder.Warn({RemarkCode::kBytesDamaged, {{"bytes", walk.damaged_bytes}}});
  if (walk.cut) builder.Warn(RemarkCode::kCutInPacket);
  const auto vehicle = std::max_element(attitudes.begin(), attitudes.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  if (vehicle != attitudes.end()) {
    if (attitudes.size() > 1) {
      builder.Warn(
          {RemarkCode::kOneVehicleOf, {{"vehicles", attitudes.size()}, {"vehicle", vehicle->first}}});
    }
    MavlinkVehicle reader(builder, vehicle->first, fixes[vehicle->first] > 0);
    MavlinkWalk second;
    second.Run(bytes, consumed, [&](const MavlinkPacket& packet) { reader.Take(packet); });
    reader.Finish();
  }
  if (walk.counts[kRawImu] > 0 && builder.imu_count() == 0) {
    builder.Warn(RemarkCode::kImuTooSlow);
  }
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
