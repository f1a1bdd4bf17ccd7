// MavlinkVehicle: what one vehicle of a telemetry log sent, packet by packet, as samples of a LogBuilder.
// Messages without a time of the vehicle are placed by the ground station's clock. One thread.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/autopilots/mavlink_packet.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {

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

class MavlinkVehicle {
 public:
  // `has_gps`: raw fixes are among the packets, so that the autopilot's own solution is not taken beside
  // them.
  MavlinkVehicle(LogBuilder& builder, std::uint8_t system_id, bool has_gps)
      : builder_(builder), system_(system_id), has_gps_(has_gps) {}

  // Packets of other vehicles are passed over.
  void Take(const MavlinkPacket& packet);
  // Sets the log's clock and hands on the camera events, which need it.
  void Finish();

 private:
  // With a Unix time to be placed at the end, or 0.
  using Events = std::vector<std::pair<CameraEvent, std::uint64_t>>;

  // The vehicle's clock, noting how the ground station's runs against it.
  double Boot(const MavlinkPacket& packet, std::uint32_t boot_ms);
  // For messages without a time of the vehicle: what its clock must be about now.
  double FromGround(const MavlinkPacket& packet) const;
  // Fields named time_usec hold the time since boot or Unix time, at the sender's choice.
  double EitherClock(const MavlinkPacket& packet, std::uint64_t us) const;
  // Cameras may count from their own start: by how much less than the vehicle does.
  double CameraBehindS() const;
  void TakeGlobalPosition(const MavlinkPacket& packet);
  void TakeGps(const MavlinkPacket& packet);
  void TakeImu(const MavlinkPacket& packet);
  void TakeGimbal(const MavlinkPacket& packet);
  void TakeFeedback(const MavlinkPacket& packet);
  // PX4 hands the vehicle's own attitude on as that of the camera.
  bool CameraIsFixed() const;
  void TakeImageCaptured(const MavlinkPacket& packet);
  void Keep(Events& list, CameraEvent event, const MavlinkPacket& packet, std::uint64_t us);

  LogBuilder& builder_;
  std::uint8_t system_;
  bool has_gps_;
  ClockPairs vehicle_clock_;
  ClockPairs ground_clock_;
  double last_boot_s_ = 0.0;
  std::uint64_t last_ground_us_ = 0;
  std::optional<double> heading_rad_;
  std::optional<Eigen::Quaterniond> ned_from_body_;  // the latest
  std::optional<std::uint8_t> gimbal_;               // the first of them
  bool has_mount_ = false;                           // whose orientation counts by the vehicle's clock
  Events events_[3];                                 // the best kind first
  // Of each CAMERA_IMAGE_CAPTURED: how long after its time it came, and by how much it was turned against the
  // vehicle.
  std::vector<double> image_late_s_, image_off_body_rad_;
};

}  // namespace skyquilt::flight
