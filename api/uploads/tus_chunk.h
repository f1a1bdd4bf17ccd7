// The bytes of one tus request, behind what its upload has.
#pragma once

#include <functional>
#include <string>

#include "api/auth/quota.h"
#include "api/uploads/tus_answers.h"

namespace skyquilt::api {

// Turns the upload as it is when the bytes are in into the response.
using TusChunkAnswer = std::function<Response(const storage::SpooledUpload&)>;

// Whether the body has the type of such bytes.
bool IsTusChunk(const Request& request);
TusBegun BeginTusChunk(Service& service, const Request& request, const std::string& id, std::int64_t offset,
                       TusChunkAnswer answer);

// Whose quota the bytes of an upload count towards: that of its flight's owner; of a part, its own owner's.
Result<IncomingBytes> TusBytes(Service& service, const std::string& flight_id, const std::string& owner);

}  // namespace skyquilt::api
