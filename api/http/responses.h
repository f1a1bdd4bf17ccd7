// The few shapes of answers that handlers share. Pure.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

Response Json(int status, std::string body);
Response NoContent();
Response Text(int status, std::string body, std::string content_type);
// The same with a tag of its body, which is left out where the client has it.
Response Tagged(const Request& request, Response response);

inline constexpr std::size_t kMaxCollectedBytes = std::size_t{64} << 10;
// Collects a body of at most `max_bytes` and hands it to `answer`.
std::unique_ptr<BodySink> CollectBody(std::function<Response(std::string body)> answer,
                                      std::size_t max_bytes = kMaxCollectedBytes);

// kNotFound for what cannot be an id of ours, before it comes near the disk.
Result<void> CheckId(const std::string& id, const char* what);
// True for application/json, and for a request without a body type.
bool IsJson(const Request& request);

}  // namespace skyquilt::api
