#include <memory>
#include <utility>

#include "api/flights/flights.h"
#include "api/http/digest.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/uploads/files.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"
#include "storage/uploads/unpack_archive.h"

namespace skyquilt::api {
namespace {

// One raw body into one file of a flight.
class PutFile final : public BodySink {
 public:
  // `sha256`: what Content-Digest says of the bytes, if it came.
  PutFile(Service& service, Request request, storage::Upload upload, IncomingBytes incoming,
          std::optional<std::string> sha256)
      : service_(service),
        request_(std::move(request)),
        upload_(std::move(upload)),
        incoming_(std::move(incoming)),
        sha256_(std::move(sha256)) {}

  Result<void> Write(std::span<const std::uint8_t> bytes) override {
    SKYQUILT_TRY(incoming_.Take(static_cast<std::int64_t>(bytes.size())));
    if (sha256_) digest_.Add(bytes);
    return upload_.Write(bytes);
  }

  Response Finish() override {
    const std::string& flight_id = request_.Parameter("flight");
    const std::int64_t bytes = upload_.bytes();
    if (sha256_ && digest_.Finish() != *sha256_) {
      return Problem({ErrorCode::kDigestMismatch,
                      "The bytes are not those that Content-Digest says. Send them again.", ""},
                     request_);
    }
    Result<std::string> stored = upload_.Finish();
    if (!stored) return Problem(stored.error(), request_);
    const storage::StoredFile file{request_.Parameter("name"), *stored, bytes};
    const Result<storage::AddedFile> added = service_.catalogue.AddFile(flight_id, file, storage::Now());
    if (!added) {
      service_.store.Remove(flight_id, *stored);
      return Problem(added.error(), request_);
    }
    incoming_.Kept(bytes);
    if (added->replaced) service_.store.Remove(flight_id, added->replaced_stored_name);
    if (!storage::IsArchiveName(file.name)) return Json(added->replaced ? 200 : 201, FileJson(file));
    const Result<std::vector<FileOutcome>> outcomes = UnpackStored(service_, flight_id, file);
    if (!outcomes) return Problem(outcomes.error(), request_);
    return Json(201, JsonObject({{"files", FileOutcomesJson(*outcomes)}}));
  }

 private:
  Service& service_;
  Request request_;
  storage::Upload upload_;
  IncomingBytes incoming_;
  std::optional<std::string> sha256_;
  Digest digest_{DigestAlgorithm::kSha256};
};

std::variant<std::unique_ptr<BodySink>, Response> BeginPut(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  const Result<void> checked = CheckId(flight_id, "flight");
  if (!checked) return Problem(checked.error(), request);
  const Result<void> named = storage::CheckFileName(request.Parameter("name"));
  if (!named) return Problem(named.error(), request);
  const Result<bool> known = service.catalogue.HasFlight(flight_id);
  if (!known) return Problem(known.error(), request);
  if (!*known) return Problem({ErrorCode::kNotFound, "There is no such flight.", ""}, request);
  Result<IncomingBytes> incoming = IncomingBytes::Into(service, flight_id);
  if (!incoming) return Problem(incoming.error(), request);
  const Result<void> fits = incoming->CheckRoom(request.content_length);
  if (!fits) return Problem(fits.error(), request);
  Result<storage::Upload> upload =
      service.store.Begin(flight_id, static_cast<std::int64_t>(std::min<std::uint64_t>(
                                         request.content_length.value_or(0), storage::kMaxFileBytes + 1)));
  if (!upload) return Problem(upload.error(), request);
  std::optional<std::string> sha256;
  if (request.headers.Has("Content-Digest")) {
    sha256 = Sha256OfContentDigest(request.headers.Find("Content-Digest"));
    if (!sha256) {
      return Problem({ErrorCode::kInvalidArgument, "Content-Digest has no sha-256 that can be read.", ""},
                     request);
    }
  }
  return std::make_unique<PutFile>(service, request, *std::move(upload), *std::move(incoming),
                                   std::move(sha256));
}

Response ListFiles(Service& service, const Request& request) {
  const Result<void> checked = CheckId(request.Parameter("flight"), "flight");
  if (!checked) return Problem(checked.error(), request);
  const Result<void> there = RequireFlight(service, request.Parameter("flight"));
  if (!there) return Problem(there.error(), request);
  const Result<std::vector<storage::StoredFile>> files =
      service.catalogue.ListFiles(request.Parameter("flight"));
  if (!files) return Problem(files.error(), request);
  std::vector<std::string> items;
  for (const storage::StoredFile& file : *files) items.push_back(FileJson(file));
  return Json(200, JsonObject({{"files", JsonArray(items)}}));
}

Response DeleteFile(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  const Result<void> checked = CheckId(flight_id, "flight");
  if (!checked) return Problem(checked.error(), request);
  const Result<storage::StoredFile> removed =
      service.db.Free([&] { return service.catalogue.RemoveFile(flight_id, request.Parameter("name")); });
  if (!removed) return Problem(removed.error(), request);
  service.store.Remove(flight_id, removed->stored_name);
  service.db.FillReserve();
  return NoContent();
}

}  // namespace

void AddFileRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/files",
             [&](const Request& r) { return ListFiles(service, r); });
  router.AddUpload(Method::kPut, "/api/v1/flights/{flight}/files/{name}",
                   [&](const Request& r) { return BeginPut(service, r); });
  router.Add(Method::kDelete, "/api/v1/flights/{flight}/files/{name}",
             [&](const Request& r) { return DeleteFile(service, r); });
}

}  // namespace skyquilt::api
