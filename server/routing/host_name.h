// Hosts that a request was sent to, as Host and X-Forwarded-Host say them: what is one at all (RFC 3986,
// 3.2.2), and which are this server's. One rule for both, for either ends up in links. Pure but for the list
// of this machine's addresses, which is asked anew every few seconds; any thread.
#pragma once

#include <optional>
#include <string_view>

#include "server/routing/http_settings.h"

namespace skyquilt::server {

// "maps.example.org:8443", "192.0.2.7", "[::1]:80": the name alone, without brackets and port. Absent: no
// host. A name has labels of letters, digits, - and _; a port is 1 to 65535.
std::optional<std::string_view> NameOfHost(std::string_view host);

// A loopback name, the address that is listened at (or any of this machine's where that is 0.0.0.0 or ::), or
// one that the operator named (--host, --public-url); with or without a port.
bool IsOwnHost(std::string_view host, const HttpSettings& settings);

}  // namespace skyquilt::server
