// CompressAnswer: text and JSON as gzip for clients that take it (RFC 9110, 8.4), where it is worth the time:
// not what is small, not parts of files, not pictures, which are compressed already. A strong ETag becomes a
// weak one, for the bytes are others. Takes processor time and reads the answer's file: not where sockets are
// served. Errors: those of reading the file.
#pragma once

#include <string_view>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

// By Accept-Encoding: "gzip", "br".
bool TakesCoding(const Request& request, std::string_view coding);

Result<void> CompressAnswer(const Request& request, Response& response);

}  // namespace skyquilt::api
