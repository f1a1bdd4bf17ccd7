// tus 1.0 at /api/v1/uploads: resumable uploads of one file each, with the extensions creation,
// creation-with-upload, creation-defer-length, expiration, checksum, termination and concatenation. The
// metadata name the flight ("flight") and the file ("filename"). https://tus.io/protocols/resumable-upload
#include <nlohmann/json.hpp>
#include <utility>

#include "api/auth/flight_access.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/uploads/tus_chunk.h"
#include "api/uploads/tus_headers.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using storage::SpooledUpload;

Error BadCreation(const char* why) { return {ErrorCode::kInvalidArgument, why}; }

// Absent without Upload-Concat.
Result<std::optional<TusConcat>> ConcatOf(const Request& request) {
  if (!request.headers.Has("Upload-Concat")) return std::optional<TusConcat>();
  std::optional<TusConcat> concat = ParseTusConcat(request.headers.Find("Upload-Concat"));
  if (!concat) {
    return BadCreation(
        "Upload-Concat (the extension concatenation) must be \"partial\", or \"final;\" and the addresses of "
        "the parts with a space between.");
  }
  if (concat->is_final &&
      (request.headers.Has("Upload-Length") || request.headers.Has("Upload-Defer-Length"))) {
    return BadCreation(
        "A final upload (the extension concatenation) is as long as its parts: leave out Upload-Length.");
  }
  return concat;
}

Result<void> TakeMetadata(const Request& request, bool is_part, SpooledUpload& wanted) {
  wanted.metadata = request.headers.Find("Upload-Metadata");
  const auto metadata = ParseTusMetadata(wanted.metadata);
  if (!metadata) return BadCreation("Upload-Metadata is not a list of keys with base64 values.");
  if (is_part) return {};  // what the whole is, its last request says
  const auto value = [&](const char* key) {
    const auto found = metadata->find(key);
    return found == metadata->end() ? std::string() : found->second;
  };
  wanted.flight_id = value("flight");
  wanted.name = value("filename");
  if (wanted.flight_id.empty() || wanted.name.empty()) {
    return BadCreation("Upload-Metadata must have \"flight\" (the flight's id) and \"filename\".");
  }
  return CheckId(wanted.flight_id, "flight");
}

// The upload that a creation request describes.
Result<SpooledUpload> RequestedUpload(const Request& request, const std::optional<TusConcat>& concat) {
  SpooledUpload wanted;
  wanted.owner = request.owner;
  if (concat) wanted.concat = request.headers.Find("Upload-Concat");
  SKYQUILT_TRY(TakeMetadata(request, concat && !concat->is_final, wanted));
  if (concat && concat->is_final) return wanted;
  const bool has_length = request.headers.Has("Upload-Length");
  const bool is_deferred = request.headers.Has("Upload-Defer-Length");
  if (has_length == is_deferred)
    return BadCreation(
        "Say either Upload-Length or Upload-Defer-Length: 1 (the extension creation-defer-length).");
  if (is_deferred && request.headers.Find("Upload-Defer-Length") != "1")
    return BadCreation("Upload-Defer-Length (the extension creation-defer-length) must be 1.");
  if (has_length) {
    wanted.length = ParseTusNumber(request.headers.Find("Upload-Length"));
    if (!wanted.length) return BadCreation("Upload-Length is not a number.");
    if (*wanted.length == 0) {
      return Error{ErrorCode::kUnprocessable, "The file is empty. Was it copied completely from the card?"};
    }
  }
  return wanted;
}

Response Created(const Service& service, const SpooledUpload& upload) {
  Response response = TusAnswer(Response());
  response.status = 201;
  response.headers.Add("Location", "/api/v1/uploads/" + upload.id);
  DescribeTus(service, upload, response);
  return response;
}

// Bytes of parts are counted already: towards the quota of the flight's owner only if that is another's.
Result<IncomingBytes> CountParts(Service& service, const Request& request, const std::string& flight_id,
                                 const std::vector<std::string>& parts) {
  SKYQUILT_TRY_ASSIGN(const std::string flight_owner, service.catalogue.OwnerOf(flight_id));
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::For(service, flight_owner));
  const storage::Time now = service.db.ages().Now();
  for (const std::string& id : parts) {
    // What is not there or another's, Join refuses, unless the parts were joined before.
    const Result<void> may =
        request.is_admin ? Result<void>() : service.spool.CheckOwner(id, request.owner, now);
    const Result<SpooledUpload> part = may ? service.spool.Find(id, now) : may.error();
    if (!part && part.error().code != ErrorCode::kNotFound) return part.error();
    if (!part || part->owner == flight_owner) continue;
    SKYQUILT_TRY(incoming.Take(part->offset));
  }
  return incoming;
}

Result<Response> JoinParts(Service& service, const Request& request, const SpooledUpload& wanted,
                           const std::vector<std::string>& parts) {
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, CountParts(service, request, wanted.flight_id, parts));
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload,
                      service.spool.Join(wanted, parts, request.is_admin, service.db.ages().Now()));
  incoming.Kept(upload.offset);
  SKYQUILT_TRY(UnpackUpload(service, upload));
  return Created(service, upload);
}

UploadBegun BeginTusCreation(Service& service, const Request& request) {
  if (auto refused = CheckTusVersion(request)) return *std::move(refused);
  SKYQUILT_TRY_ASSIGN(const std::optional<TusConcat> concat, ConcatOf(request));
  const bool is_part = concat && !concat->is_final;
  SKYQUILT_TRY_ASSIGN(const SpooledUpload wanted, RequestedUpload(request, concat));
  const bool has_body = request.content_length.value_or(1) > 0 && request.headers.Has("Content-Type");
  if (has_body && !IsTusChunk(request)) {
    return RefuseTus(415, "The first bytes of an upload come as application/offset+octet-stream.", request);
  }
  if (!is_part) SKYQUILT_TRY(CheckMayChange(service, request, wanted.flight_id));
  const storage::Time now = service.db.ages().Now();
  SKYQUILT_TRY(service.spool.RemoveExpired(now));
  if (concat && !is_part) {
    return CollectBody(request,
                       [&service, wanted, parts = concat->parts](const Request& of, const std::string&) {
                         Result<Response> joined = JoinParts(service, of, wanted, parts);
                         return joined ? *std::move(joined) : RefuseTus(joined.error(), of);
                       });
  }
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, TusBytes(service, wanted.flight_id, wanted.owner));
  SKYQUILT_TRY(incoming.Take(wanted.length.value_or(0)));
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, service.spool.Create(wanted, now));
  incoming.Kept(wanted.length.value_or(0));  // a length that is known counts from here on
  const auto created = [&service](const SpooledUpload& made) { return Created(service, made); };
  if (has_body) return BeginTusChunk(service, request, upload.id, 0, created);
  return CollectBody(request,
                     [created, upload](const Request&, const std::string&) { return created(upload); });
}

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

UploadBegun BeginPatch(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  const std::string& id = request.Parameter("upload");
  const std::optional<std::int64_t> offset = ParseTusNumber(request.headers.Find("Upload-Offset"));
  if (!offset) return RefuseTus(400, "Upload-Offset is missing or not a number.", request);
  if (!IsTusChunk(request)) return RefuseTus(415, "Bytes come as application/offset+octet-stream.", request);
  if (request.headers.Has("Upload-Length")) {
    const std::optional<std::int64_t> length = ParseTusNumber(request.headers.Find("Upload-Length"));
    if (!length) return RefuseTus(400, "Upload-Length is not a number.", request);
    SKYQUILT_TRY(DeclareLength(service, id, *length));
  }
  return BeginTusChunk(service, request, id, *offset, [&service](const SpooledUpload& upload) {
    Response response = TusAnswer(NoContent());
    DescribeTus(service, upload, response);
    return response;
  });
}

Result<Response> GetUpload(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload,
                      service.spool.Find(request.Parameter("upload"), service.db.ages().Now()));
  SKYQUILT_TRY(UnpackUpload(service, upload));
  nlohmann::ordered_json described = {{"id", upload.id},     {"flight_id", upload.flight_id},
                                      {"name", upload.name}, {"offset", upload.offset},
                                      {"length", nullptr},   {"is_done", upload.is_done}};
  if (upload.IsPart()) described["flight_id"] = nullptr;
  if (upload.length) described["length"] = *upload.length;
  Response response = TusAnswer(JsonOf(200, described));
  DescribeTus(service, upload, response);
  if (upload.length) {
    response.headers.Add("Upload-Length", std::to_string(*upload.length));
  } else {
    response.headers.Add("Upload-Defer-Length", "1");
  }
  response.headers.Add("Upload-Metadata", upload.metadata);
  return response;
}

Result<Response> DeleteUpload(Service& service, const Request& request) {
  if (auto refused = CheckTusOwner(service, request)) return *std::move(refused);
  SKYQUILT_TRY(service.db.Free(
      [&] { return service.spool.Remove(request.Parameter("upload"), service.db.ages().Now()); }));
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
UploadBegun Overridden(Service& service, const Request& request) {
  const std::string_view method = request.headers.Find("X-HTTP-Method-Override");
  if (method == "PATCH") return BeginPatch(service, request);
  if (method != "DELETE") return RefuseTus(405, "An upload takes PATCH, HEAD and DELETE.", request);
  SKYQUILT_TRY_ASSIGN(Response deleted, DeleteUpload(service, request));
  return deleted;
}

}  // namespace

void AddTusRoutes(Router& router, Service& service) {
  constexpr const char* kOne = "/api/v1/uploads/{upload}";
  router.AddUpload(Method::kPost, "/api/v1/uploads", On(service, BeginTusCreation, RefuseTus));
  router.AddQuick(Method::kOptions, "/api/v1/uploads", Options).scope = kEverybody;
  router.AddQuick(Method::kOptions, kOne, Options).scope = kEverybody;
  router.Add(Method::kGet, kOne, On(service, GetUpload, RefuseTus));
  router.AddUpload(Method::kPatch, kOne, On(service, BeginPatch, RefuseTus));
  router.AddUpload(Method::kPost, kOne, On(service, Overridden, RefuseTus));
  router.Add(Method::kDelete, kOne, On(service, DeleteUpload, RefuseTus));
}

}  // namespace skyquilt::api
