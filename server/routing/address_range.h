// AddressRange: one IP address, or the network of those that share its first bits ("10.0.0.0/8"). A value;
// any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace skyquilt::server {

// IPv6's form; that of IPv4 is ::ffff:a.b.c.d, so that both compare.
using AddressBytes = std::array<std::uint8_t, 16>;
// Absent: not an address.
std::optional<AddressBytes> ParseAddress(std::string_view text);

struct AddressRange {
  AddressBytes first{};
  int bits = 128;  // that count

  // Absent: neither an address nor ADDRESS/BITS.
  static std::optional<AddressRange> From(std::string_view text);
  bool Contains(const AddressBytes& address) const;
};

}  // namespace skyquilt::server
