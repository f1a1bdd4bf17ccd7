// SendFile: a file as an answer: ETag, 304, If-Match, one Range, If-Range; streamed, never whole in memory.
// The file is open before the answer begins, so that it may be unlinked meanwhile. Any thread. Errors:
// kNotFound, kPreconditionFailed, kIo.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "api/http/http_message.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"

namespace skyquilt::api {

// A body of `size` bytes that can be had in parts. Errors: kPreconditionFailed (If-Match),
// kRangeNotSatisfiable, whose message is what Content-Range must say; those of `open`.
using OpenPart =
    std::function<Result<std::unique_ptr<BodySource>>(std::uint64_t offset, std::uint64_t length)>;
Result<Response> SendParts(const Request& request, std::uint64_t size, const std::string& content_type,
                           const std::string& etag, const OpenPart& open);
// The answer, or the problem document of its error, with Content-Range where it belongs.
Response Downloaded(Result<Response> sent, const Request& request);
// "attachment" under a name for saving, in the form that every browser takes (RFC 6266 with RFC 8187).
std::string Disposition(const std::string& stem, const char* extension);

// A blob, wherever it lies: a large one elsewhere comes by ranges, as the client takes it, a small one, or
// one of which a part is asked for and the sum of the whole alone is known, is fetched and kept. One that is
// not as it was published ends before its end. Also the store's errors.
Result<Response> SendBlob(const Request& request, storage::BlobStore& blobs, const std::string& key,
                          const std::string& content_type, const std::string& etag);

Result<Response> SendFile(const Request& request, const std::filesystem::path& path,
                          const std::string& content_type, const std::string& etag);

}  // namespace skyquilt::api
