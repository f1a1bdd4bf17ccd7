// Answers and names as the contract of a processing node (api/nodeodm) has them. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

Response NodeAnswer(std::string json);
Response NodeRefusal(std::string_view message, bool no_retry = false);
// An error as the contract has it: trouble that may pass is a 5xx, all else a refusal.
Response NodeProblem(const Error& error, const Request& request);
// UUID of versions 1 to 7 in the usual form, any case; answers it in lower case.
std::optional<std::string> NodeUuid(std::string_view text);

}  // namespace skyquilt::api
