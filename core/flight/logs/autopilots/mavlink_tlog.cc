#include "core/flight/logs/autopilots/mavlink_tlog.h"

#include <algorithm>
#include <map>

#include "core/flight/logs/autopilots/mavlink_packet.h"
#include "core/flight/logs/autopilots/mavlink_vehicle.h"
#include "core/flight/logs/autopilots/mavlink_walk.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {

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
  if (walk.packets == 0) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kTlogEmpty, {{"file", name}}});
  }
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
