// PublicAddress: how others reach this server, as its answers name it: the operator's --public-url, else the
// name that the request came to, below --base-path. Where the other end is a proxy that the operator trusts
// (--trusted-proxy), what that says counts before the request: X-Forwarded-Proto, -Host and -Prefix. From
// anybody else these are passed over, for they end up in documents, and so is a host that is not this
// server's: proxies pass on what their clients say. Any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "server/routing/http_settings.h"
#include "server/routing/request_head.h"

namespace skyquilt::server {

// What is a host at all (RFC 3986, 3.2.2), as Host and X-Forwarded-Host say it. "maps.example.org:8443",
// "192.0.2.7", "[::1]:80": the name alone, without brackets and port. Absent: no host. A name has labels of
// letters, digits, - and _; a port is 1 to 65535.
std::optional<std::string_view> NameOfHost(std::string_view host);

// Whether a host is this server's: a loopback name, the address that is listened at (or any of this machine's
// where that is 0.0.0.0 or ::; their list is asked anew every few seconds), or one that the operator named
// (--host, --public-url); with or without a port.
bool IsOwnHost(std::string_view host, const HttpSettings& settings);

struct PublicAddress {
  std::string base_url;   // "https://maps.example.org/skyquilt"; no slash at the end
  std::string base_path;  // "/skyquilt", or empty
};
// What a trusted proxy says that it was asked by; empty: nothing, or no host.
std::string ForwardedHost(const RequestHead& head, const std::string& peer, const HttpSettings& settings);
PublicAddress PublicAddressOf(const RequestHead& head, const std::string& peer, const HttpSettings& settings);

// "/skyquilt" or "/a/b": segments of letters, digits and -._~; empty is none.
bool IsBasePath(std::string_view text);

// What a target means below the base path: "/skyquilt/tiles/x?rev=1" is "/tiles/x?rev=1". Targets that are
// not below it stay as they are: a proxy may have taken it off.
std::string WithoutBasePath(const std::string& target, const std::string& base_path);
// "/skyquilt" itself, without the slash that addresses on the page count from.
bool IsBaseWithoutSlash(std::string_view target, const std::string& base_path);

// Location and Link name paths of this server: below the base path, as others see them.
void PutBasePath(api::Headers& headers, const std::string& base_path);

}  // namespace skyquilt::server
