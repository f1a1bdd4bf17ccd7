// Because: an error whose message is a remark's sentence, so that who shows it in another language has the
// code and its values. WhyOf: what an error says, as a remark: its reason; where it has none, the remark that
// says as much as its kind does (a full disk, cancelled); else its message. Values; any thread.
#pragma once

#include <string>

#include "core/base/result.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

Error Because(ErrorCode code, Remark reason, std::string detail = "");

Remark WhyOf(const Error& error);

// Has it more to say than its message?
bool HasReason(const Error& error);

}  // namespace skyquilt::flight
