#include "server/routing/public_address.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/base/text/plain_text.h"
#include "server/routing/address_range.h"
#include "server/routing/client_address.h"
#include "server/routing/network_addresses.h"

namespace skyquilt::server {
namespace {

constexpr std::size_t kLongestName = 255, kLongestLabel = 63;

bool IsLabel(std::string_view label) {
  return !label.empty() && label.size() <= kLongestLabel &&
         std::all_of(label.begin(), label.end(),
                     [](char c) { return IsLetterOrDigit(c) || c == '-' || c == '_'; });
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
  const auto port = ParseNumber<std::uint16_t>(text.substr(1));
  return text.front() == ':' && port && *port > 0;
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

// Of a list, which each proxy on the way adds to, the one that spoke to the client: the first.
std::string FirstOf(std::string_view list) { return std::string(Trim(list.substr(0, list.find(',')))); }

bool IsBelow(std::string_view target, std::string_view base_path) {
  return !base_path.empty() && target.starts_with(base_path) && target.size() > base_path.size() &&
         target[base_path.size()] == '/';
}

}  // namespace

std::optional<std::string_view> NameOfHost(std::string_view host) {
  if (host.empty() || host.size() > kLongestName) return std::nullopt;
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

std::string ForwardedHost(const RequestHead& head, const std::string& peer, const HttpSettings& settings) {
  if (!IsTrustedProxy(peer, settings)) return "";
  std::string host = FirstOf(head.headers.Find("X-Forwarded-Host"));
  return NameOfHost(host) ? host : "";
}

PublicAddress PublicAddressOf(const RequestHead& head, const std::string& peer,
                              const HttpSettings& settings) {
  PublicAddress address;
  address.base_path = settings.base_path;
  std::string scheme = "http";
  std::string host = head.host;
  if (IsTrustedProxy(peer, settings)) {
    if (api::EqualsIgnoringCase(FirstOf(head.headers.Find("X-Forwarded-Proto")), "https")) scheme = "https";
    const std::string forwarded = ForwardedHost(head, peer, settings);
    if (IsOwnHost(forwarded, settings)) host = forwarded;
    std::string prefix = FirstOf(head.headers.Find("X-Forwarded-Prefix"));
    while (prefix.ends_with('/')) prefix.pop_back();
    if (!prefix.empty() && IsBasePath(prefix)) address.base_path = prefix;
  }
  if (!settings.public_url.empty()) {
    address.base_url = settings.public_url;
    if (!settings.public_url.ends_with(address.base_path)) address.base_url += address.base_path;
  } else if (!host.empty()) {
    address.base_url = scheme + "://" + host + address.base_path;
  }
  return address;
}

bool IsBasePath(std::string_view text) {
  if (text.empty()) return true;
  if (text.front() != '/' || text.size() > kLongestName) return false;
  while (!text.empty()) {
    text.remove_prefix(1);
    const std::string_view segment = text.substr(0, text.find('/'));
    const bool is_plain = std::all_of(segment.begin(), segment.end(), [](char c) {
      return IsLetterOrDigit(c) || std::string_view("-._~").find(c) != std::string_view::npos;
    });
    if (segment.empty() || segment == "." || segment == ".." || !is_plain) return false;
    text.remove_prefix(segment.size());
  }
  return true;
}

std::string WithoutBasePath(const std::string& target, const std::string& base_path) {
  return IsBelow(target, base_path) ? target.substr(base_path.size()) : target;
}

bool IsBaseWithoutSlash(std::string_view target, const std::string& base_path) {
  return !base_path.empty() && target.substr(0, target.find('?')) == base_path;
}

void PutBasePath(api::Headers& headers, const std::string& base_path) {
  if (base_path.empty()) return;
  for (const auto& [name, opening] : {std::pair<const char*, std::string>{"Location", "/"}, {"Link", "</"}}) {
    const std::string value(headers.Find(name));
    const std::string_view path = std::string_view(value).substr(std::min(opening.size() - 1, value.size()));
    if (!value.starts_with(opening) || IsBelow(path, base_path)) continue;
    headers.Set(name, value.substr(0, opening.size() - 1) + base_path + value.substr(opening.size() - 1));
  }
}

}  // namespace skyquilt::server
