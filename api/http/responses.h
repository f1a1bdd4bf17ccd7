// The few shapes of answers that handlers share, and the one of every error: problem documents (RFC 9457),
// with the one table from error kinds to HTTP statuses. Pure.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

int StatusOf(ErrorCode code);
const char* ReasonOf(int status);

// The message goes to the client, the detail to the log only.
Response Problem(const Error& error, std::string_view instance, std::string_view request_id);
inline Response Problem(const Error& error, const Request& request) {
  return Problem(error, request.path, request.request_id);
}
// For what HTTP itself refuses, where no error kind says it exactly (400, 408, 413, 414, 431, 501, 505).
Response ProblemWithStatus(int status, std::string_view detail, std::string_view instance,
                           std::string_view request_id);

// The answer, or the problem document of its error.
Response Answered(Result<Response> answer, const Request& request);

Response Json(int status, std::string body);
Response JsonOf(int status, const nlohmann::ordered_json& value);
Response NoContent();
Response Text(int status, std::string body, std::string content_type);
// To be asked for anew each time, by its tag if it has one.
Response NoCache(Response response);
// Documents of standards, of JSON and so.
Response NoCacheJson(const nlohmann::ordered_json& document, const char* type = "application/json");
// So; below the line that every document of XML begins with.
Response Xml(std::string body, std::string content_type = "application/xml");
// The same with a tag of its body, which is left out where the client has it.
Response Tagged(const Request& request, Response response);

inline constexpr std::size_t kMaxCollectedBytes = std::size_t{64} << 10;
// Collects a body of at most `max_bytes` and hands it, with a copy of the request, to `answer`.
using BodyHandler = std::function<Result<Response>(const Request& request, const std::string& body)>;
std::unique_ptr<BodySink> CollectBody(const Request& request, BodyHandler answer,
                                      std::size_t max_bytes = kMaxCollectedBytes);

// kNotFound for what cannot be an id of ours, before it comes near the disk.
Result<void> CheckId(const std::string& id, const char* what);
// True for application/json, and for a request without a body type.
bool IsJson(const Request& request);

}  // namespace skyquilt::api
