#include "server/routing/public_address.h"

#include <algorithm>

#include "server/routing/client_address.h"
#include "server/routing/host_name.h"

namespace skyquilt::server {
namespace {

constexpr std::size_t kLongestName = 255;

bool IsLetterOrDigit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

// Of a list, which each proxy on the way adds to, the one that spoke to the client: the first.
std::string FirstOf(std::string_view list) {
  std::string_view first = list.substr(0, list.find(','));
  while (first.ends_with(' ')) first.remove_suffix(1);
  while (first.starts_with(' ')) first.remove_prefix(1);
  return std::string(first);
}

bool IsBelow(std::string_view target, std::string_view base_path) {
  return !base_path.empty() && target.starts_with(base_path) && target.size() > base_path.size() &&
         target[base_path.size()] == '/';
}

}  // namespace

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
