#include "server/routing/host_name.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "api/http/http_message.h"
#include "server/routing/address_range.h"
#include "server/routing/network_addresses.h"

namespace skyquilt::server {
namespace {

constexpr std::size_t kLongestHost = 255, kLongestLabel = 63;

bool IsLabel(std::string_view label) {
  return !label.empty() && label.size() <= kLongestLabel &&
         std::all_of(label.begin(), label.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
                  c == '_';
         });
}

bool IsDottedName(std::string_view name) {
  if (name.ends_with('.')) name.remove_suffix(1);  // of the root
  while (true) {
    const std::size_t dot = name.find('.');
    if (!IsLabel(name.substr(0, dot))) return false;
    if (dot == std::string_view::npos) return true;
    name.remove_prefix(dot + 1);
  }
}

bool IsIpv6Text(std::string_view text) {
  return text.find(':') != std::string_view::npos &&
         text.find_first_not_of("0123456789abcdefABCDEF:.") == std::string_view::npos &&
         ParseAddress(text).has_value();
}

// Empty, or ":8080".
bool IsPortOrNone(std::string_view text) {
  if (text.empty()) return true;
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + 1, end, port);
  return text.front() == ':' && parsed.ec == std::errc() && parsed.ptr == end && port > 0;
}

bool IsLoopbackName(std::string_view name) {
  if (name == "::1" || api::EqualsIgnoringCase(name, "localhost")) return true;
  return name.starts_with("127.") && name.find_first_not_of("0123456789.") == std::string_view::npos;
}

// Networks come and go while the server runs; a few seconds are soon enough.
bool IsAddressOfThisMachine(const AddressBytes& address) {
  constexpr std::chrono::seconds kFreshFor{5};
  static std::mutex mutex;
  static std::vector<AddressBytes> known;
  static std::optional<std::chrono::steady_clock::time_point> read_at;
  const auto now = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex);
  if (!read_at || now - *read_at > kFreshFor) {
    known.clear();
    for (const std::string& text : AddressesOfThisMachine()) {
      if (const std::optional<AddressBytes> parsed = ParseAddress(text)) known.push_back(*parsed);
    }
    read_at = now;
  }
  return std::find(known.begin(), known.end(), address) != known.end();
}

}  // namespace

std::optional<std::string_view> NameOfHost(std::string_view host) {
  if (host.empty() || host.size() > kLongestHost) return std::nullopt;
  const bool is_bracketed = host.front() == '[';
  const std::size_t end = std::min(host.find(is_bracketed ? ']' : ':'), host.size());
  if (is_bracketed && end == host.size()) return std::nullopt;
  const std::string_view name = is_bracketed ? host.substr(1, end - 1) : host.substr(0, end);
  if (!(is_bracketed ? IsIpv6Text(name) : IsDottedName(name))) return std::nullopt;
  if (!IsPortOrNone(host.substr(is_bracketed ? end + 1 : end))) return std::nullopt;
  return name;
}

bool IsOwnHost(std::string_view host, const HttpSettings& settings) {
  const std::optional<std::string_view> name = NameOfHost(host);
  if (!name) return false;
  if (IsLoopbackName(*name)) return true;
  for (const std::string& known : settings.hosts) {
    if (api::EqualsIgnoringCase(known, *name) || api::EqualsIgnoringCase(known, host)) return true;
  }
  const std::optional<AddressBytes> address = ParseAddress(*name);
  if (!address) return false;
  if (address == ParseAddress(settings.address)) return true;
  const bool is_any = settings.address == "0.0.0.0" || settings.address == "::";
  return is_any && IsAddressOfThisMachine(*address);
}

}  // namespace skyquilt::server
