#include "core/flight/logs/autopilots/mavlink_packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace skyquilt::flight {
namespace {

// Message ids with their checksum seeds (CRC_EXTRA) as common.xml and ardupilotmega.xml define them; -1: not
// known here.
struct Known {
  std::uint32_t id;
  int seed;
  const char* name;
};
constexpr std::array kKnown = {
    Known{0, 50, "HEARTBEAT"},
    Known{1, -1, "SYS_STATUS"},
    Known{2, 137, "SYSTEM_TIME"},
    Known{4, -1, "PING"},
    Known{22, -1, "PARAM_VALUE"},
    Known{24, 24, "GPS_RAW_INT"},
    Known{26, 170, "SCALED_IMU"},
    Known{27, 144, "RAW_IMU"},
    Known{29, 115, "SCALED_PRESSURE"},
    Known{30, 39, "ATTITUDE"},
    Known{31, 246, "ATTITUDE_QUATERNION"},
    Known{32, 185, "LOCAL_POSITION_NED"},
    Known{33, 104, "GLOBAL_POSITION_INT"},
    Known{35, -1, "RC_CHANNELS_RAW"},
    Known{36, -1, "SERVO_OUTPUT_RAW"},
    Known{42, -1, "MISSION_CURRENT"},
    Known{46, -1, "MISSION_ITEM_REACHED"},
    Known{62, -1, "NAV_CONTROLLER_OUTPUT"},
    Known{65, -1, "RC_CHANNELS"},
    Known{74, 20, "VFR_HUD"},
    Known{77, -1, "COMMAND_ACK"},
    Known{105, 93, "HIGHRES_IMU"},
    Known{109, -1, "RADIO_STATUS"},
    Known{111, -1, "TIMESYNC"},
    Known{112, 174, "CAMERA_TRIGGER"},
    Known{116, -1, "SCALED_IMU2"},
    Known{124, 87, "GPS2_RAW"},
    Known{125, -1, "POWER_STATUS"},
    Known{129, -1, "SCALED_IMU3"},
    Known{132, 85, "DISTANCE_SENSOR"},
    Known{136, -1, "TERRAIN_REPORT"},
    Known{137, -1, "SCALED_PRESSURE2"},
    Known{141, -1, "ALTITUDE"},
    Known{147, -1, "BATTERY_STATUS"},
    Known{150, -1, "SENSOR_OFFSETS"},
    Known{152, -1, "MEMINFO"},
    Known{163, -1, "AHRS"},
    Known{164, -1, "SIMSTATE"},
    Known{165, -1, "HWSTATUS"},
    Known{168, -1, "WIND"},
    Known{173, 83, "RANGEFINDER"},
    Known{174, -1, "AIRSPEED_AUTOCAL"},
    Known{178, -1, "AHRS2"},
    Known{180, 52, "CAMERA_FEEDBACK"},
    Known{182, -1, "AHRS3"},
    Known{193, -1, "EKF_STATUS_REPORT"},
    Known{230, -1, "ESTIMATOR_STATUS"},
    Known{241, -1, "VIBRATION"},
    Known{242, -1, "HOME_POSITION"},
    Known{245, -1, "EXTENDED_SYS_STATE"},
    Known{253, -1, "STATUSTEXT"},
    Known{263, 133, "CAMERA_IMAGE_CAPTURED"},
    Known{265, 26, "MOUNT_ORIENTATION"},
    Known{285, 137, "GIMBAL_DEVICE_ATTITUDE_STATUS"},
};

const Known* FindKnown(std::uint32_t id) {
  const auto found =
      std::lower_bound(kKnown.begin(), kKnown.end(), id,
                       [](const Known& known, std::uint32_t value) { return known.id < value; });
  return found != kKnown.end() && found->id == id ? &*found : nullptr;
}

void AccumulateCrc(std::uint16_t& crc, std::uint8_t byte) {
  auto t = static_cast<std::uint8_t>(byte ^ (crc & 0xFF));
  t = static_cast<std::uint8_t>(t ^ (t << 4));
  crc = static_cast<std::uint16_t>((crc >> 8) ^ (t << 8) ^ (t << 3) ^ (t >> 4));
}

}  // namespace

MavlinkFrame ReadMavlinkPacket(LogBytes bytes, std::size_t at, MavlinkPacket& packet) {
  constexpr std::uint64_t kYear2000Us = 946'684'800'000'000;
  constexpr std::uint64_t kYear2100Us = 4'102'444'800'000'000;
  constexpr std::size_t kStamp = 8;
  if (at > bytes.size() || bytes.size() - at < kStamp + 8) return MavlinkFrame::kCut;
  const std::uint8_t* head = bytes.data() + at + kStamp;
  packet.ground_unix_us = UnsignedAt(bytes.data() + at, kStamp, true);
  const bool is_second = head[0] == 0xFD;
  if ((head[0] != 0xFE && !is_second) || packet.ground_unix_us < kYear2000Us ||
      packet.ground_unix_us > kYear2100Us) {
    return MavlinkFrame::kDamaged;
  }
  const std::size_t head_size = is_second ? 10 : 6;
  const std::size_t payload_size = head[1];
  const std::size_t signature = is_second && (head[2] & 1) != 0 ? 13 : 0;
  packet.size = kStamp + head_size + payload_size + 2 + signature;
  if (bytes.size() - at < packet.size) return MavlinkFrame::kCut;
  if (is_second) {
    packet.system_id = head[5];
    packet.message_id = head[7] | std::uint32_t{head[8]} << 8 | std::uint32_t{head[9]} << 16;
  } else {
    packet.system_id = head[3];
    packet.message_id = head[5];
  }
  packet.payload = bytes.subspan(at + kStamp + head_size, payload_size);
  packet.checksum_known = false;
  const Known* known = FindKnown(packet.message_id);
  if (known != nullptr && known->seed >= 0) {
    std::uint16_t crc = 0xFFFF;
    for (std::size_t i = 1; i < head_size + payload_size; ++i) AccumulateCrc(crc, head[i]);
    AccumulateCrc(crc, static_cast<std::uint8_t>(known->seed));
    if (crc != LoadLittle<std::uint16_t>(head + head_size + payload_size)) return MavlinkFrame::kDamaged;
    packet.checksum_known = true;
  }
  return MavlinkFrame::kPacket;
}

std::string MavlinkMessageName(std::uint32_t message_id) {
  if (message_id > 0xFFFFFF) return "others";
  const Known* known = FindKnown(message_id);
  return known != nullptr ? known->name : fmt::format("MSG_{}", message_id);
}

}  // namespace skyquilt::flight
