// ClientAddress: who counts as one client when connections, requests and listeners are dealt out. The
// connection's other end, or, where that is a proxy the operator trusts, the last address in X-Forwarded-For
// that is none (those before it anybody can write). IPv6 counts by its first 64 bits, which one household has
// to itself. Empty for this machine itself: a proxy on it that nobody named stands for many, and would be
// bounded as one. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http_message.h"
#include "server/http_settings.h"

namespace skyquilt::server {

std::string ClientAddress(const std::string& peer, const api::Headers& headers, const HttpSettings& settings);

// An address as it is compared: "::ffff:192.0.2.1" is 192.0.2.1. Absent: not an address.
std::optional<std::string> PlainAddress(std::string_view text);

}  // namespace skyquilt::server
