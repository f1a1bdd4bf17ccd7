#include "api/uploads/tus.h"

#include <memory>
#include <utility>

#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/uploads/tus_chunk.h"
#include "api/uploads/tus_creation.h"
#include "api/uploads/tus_headers.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using storage::SpooledUpload;

// A length that comes late counts as a whole from here on.
Result<void> DeclareLength(Service& service, const std::string& id, std::int64_t length) {
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, service.spool.Find(id, service.db.ages().Now()));
  if (upload.length || length < upload.offset)
    return service.spool.DeclareLength(id, length, service.db.ages().Now());
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, TusBytes(service, upload.flight_id, upload.owner));
  SKYQUILT_TRY(incoming.Take(length - upload.offset));
  Result<void> declared = service.spool.DeclareLength(id, length, service.db.ages().Now());
  if (declared) incoming.Kept(length - upload.offset);
  return declared;
}

TusBegun BeginPatch(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  const std::string& id = request.Parameter("upload");
  const std::optional<std::int64_t> offset = ParseTusNumber(request.headers.Find("Upload-Offset"));
  if (!offset) return RefuseTus(400, "Upload-Offset is missing or not a number.", request);
  if (!IsTusChunk(request)) return RefuseTus(415, "Bytes come as application/offset+octet-stream.", request);
  if (request.headers.Has("Upload-Length")) {
    const std::optional<std::int64_t> length = ParseTusNumber(request.headers.Find("Upload-Length"));
    if (!length) return RefuseTus(400, "Upload-Length is not a number.", request);
    const Result<void> declared = DeclareLength(service, id, *length);
    if (!declared) return RefuseTus(declared.error(), request);
  }
  return BeginTusChunk(service, request, id, *offset, [&service](const SpooledUpload& upload) {
    Response response = TusAnswer(NoContent());
    DescribeTus(service, upload, response);
    return response;
  });
}

Response GetUpload(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  const Result<SpooledUpload> upload =
      service.spool.Find(request.Parameter("upload"), service.db.ages().Now());
  if (!upload) return RefuseTus(upload.error(), request);
  if (upload->file) {
    const auto unpacked = UnpackStored(service, upload->flight_id, *upload->file);
    if (!unpacked) return RefuseTus(unpacked.error(), request);
  }
  Response response = TusAnswer(Json(
      200, JsonObject({{"id", JsonString(upload->id)},
                       {"flight_id", upload->IsPart() ? "null" : JsonString(upload->flight_id)},
                       {"name", JsonString(upload->name)},
                       {"offset", std::to_string(upload->offset)},
                       {"length", upload->length ? std::to_string(*upload->length) : std::string("null")},
                       {"is_done", upload->is_done ? "true" : "false"}})));
  DescribeTus(service, *upload, response);
  if (upload->length) {
    response.headers.Add("Upload-Length", std::to_string(*upload->length));
  } else {
    response.headers.Add("Upload-Defer-Length", "1");
  }
  response.headers.Add("Upload-Metadata", upload->metadata);
  return response;
}

Response DeleteUpload(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  const Result<void> removed = service.db.Free(
      [&] { return service.spool.Remove(request.Parameter("upload"), service.db.ages().Now()); });
  if (!removed) return RefuseTus(removed.error(), request);
  return TusAnswer(NoContent());
}

Response Options(const Request&) {
  Response response = TusAnswer(NoContent());
  response.headers.Add("Tus-Version", kTusVersion);
  response.headers.Add(
      "Tus-Extension",
      "creation,creation-with-upload,creation-defer-length,expiration,checksum,termination,concatenation");
  response.headers.Add("Tus-Max-Size", std::to_string(storage::kMaxFileBytes));
  response.headers.Add("Tus-Checksum-Algorithm", "sha1,sha256");
  return response;
}

// For clients whose way lets only GET and POST through.
TusBegun Overridden(Service& service, const Request& request) {
  const std::string_view method = request.headers.Find("X-HTTP-Method-Override");
  if (method == "PATCH") return BeginPatch(service, request);
  if (method == "DELETE") return DeleteUpload(service, request);
  return RefuseTus(405, "An upload takes PATCH, HEAD and DELETE.", request);
}

}  // namespace

void AddTusRoutes(Router& router, Service& service) {
  constexpr const char* kOne = "/api/v1/uploads/{upload}";
  router.AddUpload(Method::kPost, "/api/v1/uploads",
                   [&](const Request& r) { return BeginTusCreation(service, r); });
  router.AddQuick(Method::kOptions, "/api/v1/uploads", Options).scope = kEverybody;
  router.AddQuick(Method::kOptions, kOne, Options).scope = kEverybody;
  router.Add(Method::kGet, kOne, [&](const Request& r) { return GetUpload(service, r); });
  router.AddUpload(Method::kPatch, kOne, [&](const Request& r) { return BeginPatch(service, r); });
  router.AddUpload(Method::kPost, kOne, [&](const Request& r) { return Overridden(service, r); });
  router.Add(Method::kDelete, kOne, [&](const Request& r) { return DeleteUpload(service, r); });
}

}  // namespace skyquilt::api
