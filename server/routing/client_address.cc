#include "server/routing/client_address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "core/base/text/plain_text.h"

namespace skyquilt::server {
namespace {

bool IsTrusted(const AddressBytes& address, const HttpSettings& settings) {
  return std::any_of(settings.trusted_proxies.begin(), settings.trusted_proxies.end(),
                     [&](const AddressRange& range) { return range.Contains(address); });
}

bool IsThisMachine(const AddressBytes& address) {
  static const AddressRange kLoopback = *AddressRange::From("127.0.0.0/8");
  static const AddressRange kLoopback6 = *AddressRange::From("::1");
  return kLoopback.Contains(address) || kLoopback6.Contains(address);
}

// The share is counted under this name.
std::string ShareOf(AddressBytes address) {
  static const AddressRange kIpv4 = *AddressRange::From("0.0.0.0/0");
  static const AddressRange kNeighbours = *AddressRange::From("fe80::/10");
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (kIpv4.Contains(address)) {
    inet_ntop(AF_INET, &address[12], text.data(), text.size());
  } else {
    // A household has a network of its own; neighbours on one link have the same.
    if (!kNeighbours.Contains(address)) std::fill(address.begin() + 8, address.end(), std::uint8_t{0});
    inet_ntop(AF_INET6, address.data(), text.data(), text.size());
  }
  return text.data();
}

// Several headers of one name are one list, in their order (RFC 9110, 5.3).
std::string Hops(const api::Headers& headers) {
  std::string hops;
  for (const auto& [name, value] : headers.list()) {
    if (!api::EqualsIgnoringCase(name, "X-Forwarded-For")) continue;
    if (!hops.empty()) hops += ',';
    hops += value;
  }
  return hops;
}

}  // namespace

bool IsFromThisMachine(const std::string& peer, const api::Headers& headers) {
  const std::optional<AddressBytes> address = ParseAddress(peer);
  if (!address || !IsThisMachine(*address)) return false;
  return std::none_of(headers.list().begin(), headers.list().end(), [](const auto& header) {
    constexpr std::string_view kForwarded = "X-Forwarded-";
    const std::string_view name = header.first;
    return api::EqualsIgnoringCase(name.substr(0, kForwarded.size()), kForwarded) ||
           api::EqualsIgnoringCase(name, "Forwarded") || api::EqualsIgnoringCase(name, "Via") ||
           api::EqualsIgnoringCase(name, "X-Real-IP");
  });
}

bool IsTrustedProxy(const std::string& peer, const HttpSettings& settings) {
  if (settings.trusted_proxies.empty()) return false;
  const std::optional<AddressBytes> address = ParseAddress(peer);
  return address && IsTrusted(*address, settings);
}

std::string ClientAddress(const std::string& peer, const api::Headers& headers,
                          const HttpSettings& settings) {
  std::optional<AddressBytes> address = ParseAddress(peer);
  if (!address) return "";  // the system says nothing else of a TCP connection than an address
  if (!settings.trusted_proxies.empty() && IsTrusted(*address, settings)) {
    const std::string hops = Hops(headers);
    std::string_view left = hops;
    while (!left.empty() && IsTrusted(*address, settings)) {
      const std::size_t comma = left.rfind(',');
      const std::optional<AddressBytes> hop =
          ParseAddress(Trim(comma == std::string_view::npos ? left : left.substr(comma + 1)));
      if (!hop) break;  // what a proxy could not say, nobody before it is believed about
      address = hop;
      left = comma == std::string_view::npos ? std::string_view() : left.substr(0, comma);
    }
    if (IsTrusted(*address, settings)) return "";
  }
  return IsThisMachine(*address) ? std::string() : ShareOf(*address);
}

}  // namespace skyquilt::server
