// ClientAddress: who counts as one client when connections, requests and listeners are dealt out. The
// connection's other end, or, where that is a proxy the operator trusts, the last address in X-Forwarded-For
// that is none (those before it anybody can write). IPv6 counts by its first 64 bits, which one household has
// to itself. Empty for this machine itself and for a trusted proxy that names nobody: they may stand for
// many, and would be bounded as one. Pure.
#pragma once

#include <string>

#include "api/http/http_message.h"
#include "server/routing/http_settings.h"

namespace skyquilt::server {

std::string ClientAddress(const std::string& peer, const api::Headers& headers, const HttpSettings& settings);
// Somebody at this machine asks, and not a proxy on it for others, as far as its headers say.
bool IsFromThisMachine(const std::string& peer, const api::Headers& headers);
// The other end is a proxy that the operator trusts.
bool IsTrustedProxy(const std::string& peer, const HttpSettings& settings);

}  // namespace skyquilt::server
