// Once: a request under an Idempotency-Key is carried out once; sent again it gets the first answer again,
// marked with "Idempotency-Replayed: true". Without the header it is simply carried out. Another body under
// the same key is a mistake (422). Any thread; requests with keys go one after the other.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "api/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

Response Once(Service& service, const Request& request, std::string_view body,
              const std::function<Response()>& carry_out);

// For requests whose body is too large to be compared: the answer that was kept, if any, before the body is
// read; and keeping one.
std::optional<Response> KeptAnswer(Service& service, const Request& request);
void KeepAnswer(Service& service, const Request& request, const Response& response);

}  // namespace skyquilt::api
