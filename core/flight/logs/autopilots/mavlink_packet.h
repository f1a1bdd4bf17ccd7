// One packet of a MAVLink telemetry log: framing of protocol 1 and 2, checksum, names. Any thread.
#pragma once

#include <cstdint>
#include <string>

#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

struct MavlinkPacket {
  std::uint64_t ground_unix_us = 0;  // when the ground station received it
  std::uint32_t message_id = 0;
  std::uint8_t system_id = 0;
  LogBytes payload;             // protocol 2 drops zeros at the end
  std::size_t size = 0;         // in the file, with the time in front
  bool checksum_known = false;  // we know this message's seed, and the checksum was right
};

enum class MavlinkFrame { kPacket, kDamaged, kCut };

// Reads the packet whose time stamp starts at `at`. kDamaged: no packet here, or a wrong checksum.
MavlinkFrame ReadMavlinkPacket(LogBytes bytes, std::size_t at, MavlinkPacket& packet);

// "ATTITUDE" for the common messages, else "MSG_30".
std::string MavlinkMessageName(std::uint32_t message_id);

// A field at an offset of the payload; zeros that protocol 2 dropped are put back.
template <typename T>
T MavlinkField(LogBytes payload, std::size_t offset) {
  std::uint8_t raw[sizeof(T)] = {};
  if (offset < payload.size())
    std::memcpy(raw, payload.data() + offset, std::min(sizeof(T), payload.size() - offset));
  return LoadLittle<T>(raw);
}

}  // namespace skyquilt::flight
