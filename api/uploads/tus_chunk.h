// What the tus routes have in common: their answers, what is looked at before any of them, and taking in the
// bytes of one request behind what its upload has.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "api/auth/limits.h"
#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// With the version of the protocol.
Response TusAnswer(Response response);
Response RefuseTus(const Error& error, const Request& request);
Response RefuseTus(int status, std::string_view why, const Request& request);
// How far the upload is, until when it is kept, and what it is a part of or was put together from.
void DescribeTus(const Service& service, const storage::SpooledUpload& upload, Response& response);

// What a complete upload became, where that is an archive, becomes its files. If not, the archive is gone,
// and the upload with it: who did not hear of that would take it for one that arrived.
Result<void> UnpackUpload(Service& service, const storage::SpooledUpload& upload);

std::optional<Response> CheckTusVersion(const Request& request);
// Before anything is done with an upload that is there: the version, and whose it is.
std::optional<Response> CheckTusOwner(const Service& service, const Request& request);

// Turns the upload as it is when the bytes are in into the response.
using TusChunkAnswer = std::function<Response(const storage::SpooledUpload&)>;

// Whether the body has the type of such bytes.
bool IsTusChunk(const Request& request);
UploadBegun BeginTusChunk(Service& service, const Request& request, const std::string& id,
                          std::int64_t offset, TusChunkAnswer answer);

// Whose quota the bytes of an upload count towards: that of its flight's owner; of a part, its own owner's.
Result<IncomingBytes> TusBytes(Service& service, const std::string& flight_id, const std::string& owner);

}  // namespace skyquilt::api
