// PostMessage: one POST to another server, the only outgoing request of this program, made only where its
// operator allows webhooks. The name is resolved once and the connection goes to the address that was
// checked; private addresses are refused unless allowed; redirects are not followed. TLS certificates are
// verified. Blocking, ten seconds at most. Errors: kInvalidArgument (the address), kForbidden (a private
// address), kUnavailable (no answer, or not a 2xx).
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

// False for loopback, link-local, private, multicast, reserved and translated addresses, in text form.
bool IsPublicAddress(const std::string& address);

}  // namespace skyquilt::server
