// ResponseHead: the status line and headers of an answer as bytes. Any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"

namespace skyquilt::server {

std::string ResponseHead(const api::Response& response, std::optional<std::uint64_t> content_length,
                         bool keep_alive, std::string_view request_id);

}  // namespace skyquilt::server
