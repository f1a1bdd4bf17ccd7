// SendFile: a file as an answer: ETag, 304, one Range, If-Range; streamed, never whole in memory. The file is
// open before the answer begins, so that it may be unlinked meanwhile. Any thread. Errors: kNotFound, kIo.
#pragma once

#include <filesystem>
#include <string>

#include "api/http_message.h"
#include "core/base/result.h"

namespace skyquilt::api {

Result<Response> SendFile(const Request& request, const std::filesystem::path& path,
                          const std::string& content_type, const std::string& etag);

}  // namespace skyquilt::api
