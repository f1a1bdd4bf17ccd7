#include "api/uploads/tus.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "api/auth/flight_access.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/uploads/tus_headers.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using Begun = std::variant<std::unique_ptr<BodySink>, Response>;
using storage::SpooledUpload;

constexpr int kChecksumMismatch = 460;  // tus' own
constexpr const char* kChunkType = "application/offset+octet-stream";

Response WithVersion(Response response) {
  response.headers.Add("Tus-Resumable", kTusVersion);
  return response;
}

Response Refuse(const Error& error, const Request& request) { return WithVersion(Problem(error, request)); }

Response Refuse(int status, std::string_view why, const Request& request) {
  return WithVersion(ProblemWithStatus(status, why, request.path, request.request_id));
}

std::string HttpDate(storage::Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
}

void Describe(const Service& service, const SpooledUpload& upload, Response& response) {
  response.headers.Add("Upload-Offset", std::to_string(upload.offset));
  if (!upload.is_done)
    response.headers.Add("Upload-Expires", HttpDate(service.db.ages().OnTheWall(upload.expires)));
}

std::optional<Response> CheckVersion(const Request& request) {
  if (request.headers.Find("Tus-Resumable") == kTusVersion) return std::nullopt;
  Response response = Refuse(412, "Say Tus-Resumable: 1.0.0.", request);
  response.headers.Add("Tus-Version", kTusVersion);
  return response;
}

// Before anything is done with an upload that is there: the version, and whose it is.
std::optional<Response> CheckOwner(const Service& service, const Request& request) {
  if (auto refused = CheckVersion(request)) return refused;
  if (request.is_admin) return std::nullopt;
  const Result<void> checked =
      service.spool.CheckOwner(request.Parameter("upload"), request.owner, service.db.ages().Now());
  if (checked) return std::nullopt;
  return Refuse(checked.error(), request);
}

bool IsChunk(const Request& request) {
  return EqualsIgnoringCase(request.headers.Find("Content-Type"), kChunkType);
}

// Bytes of one request, behind what the upload has.
class Chunk final : public BodySink {
 public:
  // `answer` turns the upload as it is then into the response.
  using Answer = std::function<Response(const SpooledUpload&)>;
  Chunk(Service& service, Request request, std::unique_ptr<storage::UploadSpool::Append> append,
        std::optional<TusChecksum> checksum, std::optional<IncomingBytes> incoming, Answer answer)
      : service_(service),
        request_(std::move(request)),
        append_(std::move(append)),
        checksum_(std::move(checksum)),
        incoming_(std::move(incoming)),
        saved_(append_->saved_offset()),
        answer_(std::move(answer)) {
    if (checksum_) digest_.emplace(checksum_->algorithm);
  }

  Result<void> Write(std::span<const std::uint8_t> bytes) override {
    if (incoming_) {
      SKYQUILT_TRY(incoming_->Take(static_cast<std::int64_t>(bytes.size())));
    }
    if (digest_) digest_->Add(bytes);
    Result<void> written = append_->Write(bytes);
    CountSaved();
    return written;
  }

  Response Finish() override {
    if (digest_ && digest_->Finish() != checksum_->digest) {
      return Refuse(kChecksumMismatch,
                    "The checksum is another. Nothing of this request was kept: send it again.", request_);
    }
    const Result<SpooledUpload> upload = append_->Commit(service_.db.ages().Now());
    CountSaved();
    if (!upload) return Refuse(upload.error(), request_);
    if (upload->file) {
      const auto unpacked = UnpackStored(service_, upload->flight_id, *upload->file);
      if (!unpacked) return Refuse(unpacked.error(), request_);
    }
    return answer_(*upload);
  }

 private:
  void CountSaved() {
    if (incoming_) incoming_->Kept(append_->saved_offset() - saved_);
    saved_ = append_->saved_offset();
  }

  Service& service_;
  Request request_;
  std::unique_ptr<storage::UploadSpool::Append> append_;
  std::optional<TusChecksum> checksum_;
  std::optional<Digest> digest_;
  std::optional<IncomingBytes> incoming_;  // of an upload whose length is not counted yet
  std::int64_t saved_;
  Answer answer_;
};

Result<std::optional<TusChecksum>> ChecksumOf(const Request& request) {
  if (!request.headers.Has("Upload-Checksum")) return std::optional<TusChecksum>();
  std::optional<TusChecksum> checksum = ParseTusChecksum(request.headers.Find("Upload-Checksum"));
  if (!checksum) {
    return Error{ErrorCode::kInvalidArgument,
                 "Upload-Checksum must be sha1 or sha256 with its digest in base64.", ""};
  }
  return checksum;
}

Begun BeginChunk(Service& service, const Request& request, const std::string& id, std::int64_t offset,
                 Chunk::Answer answer) {
  const Result<std::optional<TusChecksum>> checksum = ChecksumOf(request);
  if (!checksum) return Refuse(checksum.error(), request);
  const storage::Time now = service.db.ages().Now();
  Result<std::unique_ptr<storage::UploadSpool::Append>> append =
      service.spool.Begin(id, offset, checksum->has_value(), now);
  if (!append) return Refuse(append.error(), request);
  std::optional<IncomingBytes> incoming;
  if (!(*append)->has_length()) {
    Result<IncomingBytes> counted = IncomingBytes::Into(service, (*append)->flight_id());
    if (!counted) return Refuse(counted.error(), request);
    incoming.emplace(*std::move(counted));
  }
  return std::make_unique<Chunk>(service, request, *std::move(append), *checksum, std::move(incoming),
                                 std::move(answer));
}

// The upload that a creation request describes.
Result<SpooledUpload> RequestedUpload(const Request& request) {
  SpooledUpload wanted;
  const bool has_length = request.headers.Has("Upload-Length");
  const bool is_deferred = request.headers.Has("Upload-Defer-Length");
  const auto bad = [](const char* why) { return Error{ErrorCode::kInvalidArgument, why, ""}; };
  if (has_length == is_deferred) return bad("Say either Upload-Length or Upload-Defer-Length: 1.");
  if (is_deferred && request.headers.Find("Upload-Defer-Length") != "1")
    return bad("Upload-Defer-Length must be 1.");
  if (has_length) {
    wanted.length = ParseTusNumber(request.headers.Find("Upload-Length"));
    if (!wanted.length) return bad("Upload-Length is not a number.");
    if (*wanted.length == 0) {
      return Error{ErrorCode::kUnprocessable, "The file is empty. Was it copied completely from the card?",
                   ""};
    }
  }
  wanted.metadata = request.headers.Find("Upload-Metadata");
  const auto metadata = ParseTusMetadata(wanted.metadata);
  if (!metadata) return bad("Upload-Metadata is not a list of keys with base64 values.");
  const auto value = [&](const char* key) {
    const auto found = metadata->find(key);
    return found == metadata->end() ? std::string() : found->second;
  };
  wanted.owner = request.owner;
  wanted.flight_id = value("flight");
  wanted.name = value("filename");
  if (wanted.flight_id.empty() || wanted.name.empty()) {
    return bad("Upload-Metadata must have \"flight\" (the flight's id) and \"filename\".");
  }
  SKYQUILT_TRY(CheckId(wanted.flight_id, "flight"));
  return wanted;
}

Begun BeginCreation(Service& service, const Request& request) {
  if (auto refused = CheckVersion(request)) return *std::move(refused);
  const Result<SpooledUpload> wanted = RequestedUpload(request);
  if (!wanted) return Refuse(wanted.error(), request);
  const bool has_body = request.content_length.value_or(1) > 0 && request.headers.Has("Content-Type");
  if (has_body && !IsChunk(request)) {
    return Refuse(415, "The first bytes of an upload come as application/offset+octet-stream.", request);
  }
  const Result<void> may = CheckMayChange(service, request, wanted->flight_id);
  if (!may) return Refuse(may.error(), request);
  const storage::Time now = service.db.ages().Now();
  const Result<int> expired = service.spool.RemoveExpired(now);
  if (!expired) return Refuse(expired.error(), request);
  Result<IncomingBytes> incoming = IncomingBytes::Into(service, wanted->flight_id);
  if (!incoming) return Refuse(incoming.error(), request);
  const Result<void> fits = incoming->Take(wanted->length.value_or(0));
  if (!fits) return Refuse(fits.error(), request);
  const Result<SpooledUpload> upload = service.spool.Create(*wanted, now);
  if (!upload) return Refuse(upload.error(), request);
  incoming->Kept(wanted->length.value_or(0));  // a length that is known counts from here on
  const auto created = [&service](const SpooledUpload& made) {
    Response response = WithVersion(Response());
    response.status = 201;
    response.headers.Add("Location", "/api/v1/uploads/" + made.id);
    Describe(service, made, response);
    return response;
  };
  if (has_body) return BeginChunk(service, request, upload->id, 0, created);
  return CollectBody([created, made = *upload](const std::string&) { return created(made); });
}

// A length that comes late counts as a whole from here on.
Result<void> DeclareLength(Service& service, const std::string& id, std::int64_t length) {
  SKYQUILT_TRY_ASSIGN(const SpooledUpload upload, service.spool.Find(id, service.db.ages().Now()));
  if (upload.length || length < upload.offset)
    return service.spool.DeclareLength(id, length, service.db.ages().Now());
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, upload.flight_id));
  SKYQUILT_TRY(incoming.Take(length - upload.offset));
  Result<void> declared = service.spool.DeclareLength(id, length, service.db.ages().Now());
  if (declared) incoming.Kept(length - upload.offset);
  return declared;
}

Begun BeginPatch(Service& service, const Request& request) {
  if (auto refused = CheckOwner(service, request)) return *std::move(refused);
  const std::string& id = request.Parameter("upload");
  const std::optional<std::int64_t> offset = ParseTusNumber(request.headers.Find("Upload-Offset"));
  if (!offset) return Refuse(400, "Upload-Offset is missing or not a number.", request);
  if (!IsChunk(request)) return Refuse(415, "Bytes come as application/offset+octet-stream.", request);
  if (request.headers.Has("Upload-Length")) {
    const std::optional<std::int64_t> length = ParseTusNumber(request.headers.Find("Upload-Length"));
    if (!length) return Refuse(400, "Upload-Length is not a number.", request);
    const Result<void> declared = DeclareLength(service, id, *length);
    if (!declared) return Refuse(declared.error(), request);
  }
  return BeginChunk(service, request, id, *offset, [&service](const SpooledUpload& upload) {
    Response response = WithVersion(NoContent());
    Describe(service, upload, response);
    return response;
  });
}

Response GetUpload(Service& service, const Request& request) {
  if (auto refused = CheckOwner(service, request)) return *std::move(refused);
  const Result<SpooledUpload> upload =
      service.spool.Find(request.Parameter("upload"), service.db.ages().Now());
  if (!upload) return Refuse(upload.error(), request);
  if (upload->file) {
    const auto unpacked = UnpackStored(service, upload->flight_id, *upload->file);
    if (!unpacked) return Refuse(unpacked.error(), request);
  }
  Response response = WithVersion(Json(
      200, JsonObject({{"id", JsonString(upload->id)},
                       {"flight_id", JsonString(upload->flight_id)},
                       {"name", JsonString(upload->name)},
                       {"offset", std::to_string(upload->offset)},
                       {"length", upload->length ? std::to_string(*upload->length) : std::string("null")},
                       {"is_done", upload->is_done ? "true" : "false"}})));
  Describe(service, *upload, response);
  if (upload->length) {
    response.headers.Add("Upload-Length", std::to_string(*upload->length));
  } else {
    response.headers.Add("Upload-Defer-Length", "1");
  }
  response.headers.Add("Upload-Metadata", upload->metadata);
  return response;
}

Response DeleteUpload(Service& service, const Request& request) {
  if (auto refused = CheckOwner(service, request)) return *std::move(refused);
  const Result<void> removed = service.db.Free(
      [&] { return service.spool.Remove(request.Parameter("upload"), service.db.ages().Now()); });
  if (!removed) return Refuse(removed.error(), request);
  return WithVersion(NoContent());
}

Response Options(const Request&) {
  Response response = WithVersion(NoContent());
  response.headers.Add("Tus-Version", kTusVersion);
  response.headers.Add("Tus-Extension",
                       "creation,creation-with-upload,creation-defer-length,expiration,checksum,termination");
  response.headers.Add("Tus-Max-Size", std::to_string(storage::kMaxFileBytes));
  response.headers.Add("Tus-Checksum-Algorithm", "sha1,sha256");
  return response;
}

// For clients whose way lets only GET and POST through.
Begun Overridden(Service& service, const Request& request) {
  const std::string_view method = request.headers.Find("X-HTTP-Method-Override");
  if (method == "PATCH") return BeginPatch(service, request);
  if (method == "DELETE") return DeleteUpload(service, request);
  return Refuse(405, "An upload takes PATCH, HEAD and DELETE.", request);
}

}  // namespace

void AddTusRoutes(Router& router, Service& service) {
  constexpr const char* kOne = "/api/v1/uploads/{upload}";
  router.AddUpload(Method::kPost, "/api/v1/uploads",
                   [&](const Request& r) { return BeginCreation(service, r); });
  router.AddQuick(Method::kOptions, "/api/v1/uploads", Options);
  router.AddQuick(Method::kOptions, kOne, Options);
  router.Add(Method::kGet, kOne, [&](const Request& r) { return GetUpload(service, r); });
  router.AddUpload(Method::kPatch, kOne, [&](const Request& r) { return BeginPatch(service, r); });
  router.AddUpload(Method::kPost, kOne, [&](const Request& r) { return Overridden(service, r); });
  router.Add(Method::kDelete, kOne, [&](const Request& r) { return DeleteUpload(service, r); });
}

}  // namespace skyquilt::api
