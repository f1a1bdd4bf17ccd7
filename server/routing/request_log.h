// The server's log: JSON lines on stderr, each with the id that the answer carried. Any thread.
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace skyquilt::server {

// Unique within a run of the server and cheap.
std::string NextRequestId();
void LogResponse(std::string_view request_id, std::string_view method, std::string_view path, int status,
                 std::string_view what);
void LogFailure(std::string_view request_id, std::string_view where, std::string_view what);
// Of errors some say all in the message, some in the detail.
void LogFailure(std::string_view request_id, std::string_view where, const Error& why);
// What ended a connection's coroutine, if anything did.
void LogUncaught(const std::exception_ptr& failure);
void LogEvent(std::string_view what);

}  // namespace skyquilt::server
