// Once: a request with an Idempotency-Key is carried out once; when it is sent again it gets the first
// answer, marked with "Idempotency-Replayed: true". One that was refused was not carried out: it may be sent
// again under its key. Without the header it is simply carried out. Another body under the same key is
// refused (422); keys of different tokens are independent. Any thread; requests with keys are serialised.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

Response Once(Service& service, const Request& request, std::string_view body,
              const std::function<Result<Response>()>& carry_out);

// The same for a body that is too large to be kept: by a digest of what it says.
Response OnceBy(Service& service, const Request& request, const std::string& fingerprint,
                const std::function<Result<Response>()>& carry_out);
// Before the body is read: true where it need only be compared. Errors: kInvalidArgument (no good key), and
// the catalogue's.
Result<bool> HasKeptAnswer(Service& service, const Request& request);

}  // namespace skyquilt::api
