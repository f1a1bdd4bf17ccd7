// What all answers of the tus routes have in common, and what is looked at before any of them.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <variant>

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

using TusBegun = std::variant<std::unique_ptr<BodySink>, Response>;

// With the version of the protocol.
Response TusAnswer(Response response);
Response RefuseTus(const Error& error, const Request& request);
Response RefuseTus(int status, std::string_view why, const Request& request);
// How far the upload is, until when it is kept, and what it is a part of or was put together from.
void DescribeTus(const Service& service, const storage::SpooledUpload& upload, Response& response);

std::optional<Response> CheckTusVersion(const Request& request);
// Before anything is done with an upload that is there: the version, and whose it is.
std::optional<Response> CheckTusOwner(const Service& service, const Request& request);

}  // namespace skyquilt::api
