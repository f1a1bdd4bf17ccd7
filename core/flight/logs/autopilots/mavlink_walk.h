// MavlinkWalk: one pass over the packets of a telemetry log. One thread.
#pragma once

#include <map>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/autopilots/mavlink_packet.h"

namespace skyquilt::flight {

// Numbers of messages that are counted apart; vehicles send some hundred kinds. The others count as
// kOtherMavlink.
inline constexpr std::size_t kMaxMavlinkKinds = 1000;
inline constexpr std::uint32_t kOtherMavlink = 0xFFFFFFFF;  // numbers have 24 bits

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

}  // namespace skyquilt::flight
