// Problem documents (RFC 9457): the one shape of every error answer, and the one table from error kinds to
// HTTP statuses. The message goes to the client, the detail to the log only. Pure.
#pragma once

#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

int StatusOf(ErrorCode code);
const char* ReasonOf(int status);

Response Problem(const Error& error, std::string_view instance, std::string_view request_id);
inline Response Problem(const Error& error, const Request& request) {
  return Problem(error, request.path, request.request_id);
}
// For what HTTP itself refuses, where no error kind says it exactly (400, 408, 413, 414, 431, 501, 505).
Response ProblemWithStatus(int status, std::string_view detail, std::string_view instance,
                           std::string_view request_id);

}  // namespace skyquilt::api
