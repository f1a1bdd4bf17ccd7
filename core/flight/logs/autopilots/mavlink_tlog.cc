#include <algorithm>
#include <map>

#include "core/flight/logs/autopilots/mavlink_packet.h"
#include "core/flight/logs/autopilots/mavlink_vehicle.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {
namespace {

// Numbers of messages that are counted apart; vehicles send some hundred kinds. The others count as
// kOtherMavlink.
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
