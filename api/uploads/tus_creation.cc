#include "api/uploads/tus_creation.h"

#include <memory>
#include <utility>

#include "api/auth/flight_access.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/uploads/tus_chunk.h"
#include "api/uploads/tus_headers.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using storage::SpooledUpload;

Error BadCreation(const char* why) { return {ErrorCode::kInvalidArgument, why, ""}; }

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
      return Error{ErrorCode::kUnprocessable, "The file is empty. Was it copied completely from the card?",
                   ""};
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
    if (!request.is_admin && !service.spool.CheckOwner(id, request.owner, now)) continue;
    const Result<SpooledUpload> part = service.spool.Find(id, now);
    if (!part && part.error().code != ErrorCode::kNotFound) return part.error();
    if (!part || part->owner == flight_owner) continue;
    SKYQUILT_TRY(incoming.Take(part->offset));
  }
  return incoming;
}

Response JoinParts(Service& service, const Request& request, const SpooledUpload& wanted,
                   const std::vector<std::string>& parts) {
  Result<IncomingBytes> incoming = CountParts(service, request, wanted.flight_id, parts);
  if (!incoming) return RefuseTus(incoming.error(), request);
  const Result<SpooledUpload> upload =
      service.spool.Join(wanted, parts, request.is_admin, service.db.ages().Now());
  if (!upload) return RefuseTus(upload.error(), request);
  incoming->Kept(upload->offset);
  if (upload->file) {
    const auto unpacked = UnpackStored(service, upload->flight_id, *upload->file);
    if (!unpacked) return RefuseTus(unpacked.error(), request);
  }
  return Created(service, *upload);
}

}  // namespace

TusBegun BeginTusCreation(Service& service, const Request& request) {
  if (auto refused = CheckTusVersion(request)) return *std::move(refused);
  const Result<std::optional<TusConcat>> concat = ConcatOf(request);
  if (!concat) return RefuseTus(concat.error(), request);
  const bool is_part = *concat && !(*concat)->is_final;
  const Result<SpooledUpload> wanted = RequestedUpload(request, *concat);
  if (!wanted) return RefuseTus(wanted.error(), request);
  const bool has_body = request.content_length.value_or(1) > 0 && request.headers.Has("Content-Type");
  if (has_body && !IsTusChunk(request)) {
    return RefuseTus(415, "The first bytes of an upload come as application/offset+octet-stream.", request);
  }
  const Result<void> may = is_part ? Result<void>() : CheckMayChange(service, request, wanted->flight_id);
  if (!may) return RefuseTus(may.error(), request);
  const storage::Time now = service.db.ages().Now();
  const Result<int> expired = service.spool.RemoveExpired(now);
  if (!expired) return RefuseTus(expired.error(), request);
  if (*concat && !is_part) {
    return CollectBody([&service, request, wanted = *wanted, parts = (*concat)->parts](const std::string&) {
      return JoinParts(service, request, wanted, parts);
    });
  }
  Result<IncomingBytes> incoming = TusBytes(service, wanted->flight_id, wanted->owner);
  if (!incoming) return RefuseTus(incoming.error(), request);
  const Result<void> fits = incoming->Take(wanted->length.value_or(0));
  if (!fits) return RefuseTus(fits.error(), request);
  const Result<SpooledUpload> upload = service.spool.Create(*wanted, now);
  if (!upload) return RefuseTus(upload.error(), request);
  incoming->Kept(wanted->length.value_or(0));  // a length that is known counts from here on
  const auto created = [&service](const SpooledUpload& made) { return Created(service, made); };
  if (has_body) return BeginTusChunk(service, request, upload->id, 0, created);
  return CollectBody([created, made = *upload](const std::string&) { return created(made); });
}

}  // namespace skyquilt::api
