// PostMessage: one POST to another server, the only outgoing request of this program, made only where its
// operator allows webhooks. Each address of the name is checked when its socket is opened, so that what was
// checked is what is connected to; private ones are refused unless allowed. Redirects are not followed and
// proxies not used. TLS certificates are verified (SSL_CERT_FILE names others to trust). Blocking, ten
// seconds at most; any thread. Errors: kInvalidArgument (the address), kForbidden (a private address),
// kUnavailable (no answer, or not a 2xx).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

struct OutgoingMessage {
  std::string url;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  bool may_go_private = false;
};

Result<void> PostMessage(const OutgoingMessage& message);

// For who names a receiver: that its address, or one of those its name has now, is public. Loopback,
// link-local, private, multicast, reserved and translated addresses are not. Looks the name up, which may
// take the resolver's seconds. Errors: kUnprocessable.
Result<void> CheckReceiver(const std::string& url);

}  // namespace skyquilt::server
