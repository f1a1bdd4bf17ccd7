#include "api/common/node_answers.h"

#include <nlohmann/json.hpp>

#include "api/http/responses.h"
#include "core/base/text/json_io.h"

namespace skyquilt::api {

Response NodeAnswer(std::string json) { return Json(200, std::move(json)); }

Response NodeRefusal(std::string_view message, bool no_retry) {
  nlohmann::ordered_json answer;
  answer["error"] = message;
  if (no_retry) answer["noRetry"] = true;
  return NodeAnswer(JsonText(answer));
}

Response NodeProblem(const Error& error, const Request& request) {
  if (StatusOf(error.code) >= 500) return Problem(error, request);
  return NodeRefusal(error.message);
}

std::optional<std::string> NodeUuid(std::string_view text) {
  if (text.size() != 36) return std::nullopt;
  std::string uuid(text);
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    const bool is_dash = i == 8 || i == 13 || i == 18 || i == 23;
    if (uuid[i] >= 'A' && uuid[i] <= 'F') uuid[i] = static_cast<char>(uuid[i] - 'A' + 'a');
    const bool is_hex = (uuid[i] >= '0' && uuid[i] <= '9') || (uuid[i] >= 'a' && uuid[i] <= 'f');
    if (is_dash ? uuid[i] != '-' : !is_hex) return std::nullopt;
  }
  const bool has_version = uuid[14] >= '1' && uuid[14] <= '7';
  const bool has_variant = std::string_view("89ab").find(uuid[19]) != std::string_view::npos;
  if (!has_version || !has_variant) return std::nullopt;
  return uuid;
}

}  // namespace skyquilt::api
