#include "server/client_address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace skyquilt::server {
namespace {

bool IsTrusted(const std::string& address, const HttpSettings& settings) {
  return std::find(settings.trusted_proxies.begin(), settings.trusted_proxies.end(), address) !=
         settings.trusted_proxies.end();
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

// The share is counted under this name.
std::string ShareOf(const std::string& address) {
  if (address.empty() || address.starts_with("127.") || address == "::1") return "";
  in6_addr bytes{};
  if (inet_pton(AF_INET6, address.c_str(), &bytes) != 1) return address;
  std::memset(&bytes.s6_addr[8], 0, 8);
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(AF_INET6, &bytes, text.data(), text.size());
  return text.data();
}

}  // namespace

std::optional<std::string> PlainAddress(std::string_view text) {
  const std::string address(text);
  std::array<char, INET6_ADDRSTRLEN> plain{};
  in_addr four{};
  if (inet_pton(AF_INET, address.c_str(), &four) == 1) {
    inet_ntop(AF_INET, &four, plain.data(), plain.size());
    return plain.data();
  }
  in6_addr six{};
  if (inet_pton(AF_INET6, address.c_str(), &six) != 1) return std::nullopt;
  if (IN6_IS_ADDR_V4MAPPED(&six)) {
    inet_ntop(AF_INET, &six.s6_addr[12], plain.data(), plain.size());
  } else {
    inet_ntop(AF_INET6, &six, plain.data(), plain.size());
  }
  return plain.data();
}

std::string ClientAddress(const std::string& peer, const api::Headers& headers,
                          const HttpSettings& settings) {
  std::string address = PlainAddress(peer).value_or("");
  if (!IsTrusted(address, settings)) return ShareOf(address);
  // Several headers of one name are one list, in their order (RFC 9110, 5.3).
  std::string hops;
  for (const auto& [name, value] : headers.list()) {
    if (!api::EqualsIgnoringCase(name, "X-Forwarded-For")) continue;
    if (!hops.empty()) hops += ',';
    hops += value;
  }
  std::string_view left = hops;
  while (!left.empty()) {
    const std::size_t comma = left.rfind(',');
    const std::string_view last = comma == std::string_view::npos ? left : left.substr(comma + 1);
    left = comma == std::string_view::npos ? std::string_view() : left.substr(0, comma);
    const std::optional<std::string> hop = PlainAddress(Trimmed(last));
    if (!hop) break;  // what a proxy could not say, nobody before it is believed about
    address = *hop;
    if (!IsTrusted(address, settings)) break;
  }
  return ShareOf(address);
}

}  // namespace skyquilt::server
