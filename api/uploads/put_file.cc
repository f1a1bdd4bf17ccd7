// The files of one flight: list, raw PUT (curl -T), delete.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "api/common/find_flight.h"
#include "api/http/digest.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/uploads/flight_document.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"
#include "storage/uploads/unpack_archive.h"

namespace skyquilt::api {
namespace {

using storage::StoredFile;

// A second card has other photos under the names of the first one's.
Error AnotherIsThere(const StoredFile& known) {
  return {ErrorCode::kConflict,
          fmt::format(
              "This flight has another file \"{0}\" already, of {1} bytes. To keep both, send this one "
              "under another name, with its folder's in front, say: .../files/101MEDIA_{0}. To put it in the "
              "other's place, send the header If-Match: * with it.",
              known.name, known.bytes)};
}

bool MayReplace(const Request& request) { return !request.headers.Find("If-Match").empty(); }

// What lies where the file is to go. kPreconditionFailed where it is not what If-Match names.
Result<std::optional<StoredFile>> FindInItsPlace(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(std::optional<StoredFile> known,
                      service.catalogue.FindFile(request.Parameter("flight"), request.Parameter("name")));
  SKYQUILT_TRY(CheckIfMatch(request, known, "The file is not, or no more, the one that If-Match names."));
  return known;
}

// Nothing: the flight has the same bytes under this name already.
Result<std::optional<storage::AddedFile>> AddInItsPlace(Service& service, const Request& request,
                                                        const StoredFile& file) {
  const std::string& flight_id = request.Parameter("flight");
  constexpr int kMaxTurns = 5;
  for (int turn = 1;; ++turn) {
    SKYQUILT_TRY_ASSIGN(const std::optional<StoredFile> known, FindInItsPlace(service, request));
    if (known && !MayReplace(request)) {
      const Result<bool> is_same = HaveSameBytes(service, flight_id, *known, file);
      // Replaced or removed since it was found; one whose bytes are lost can only be replaced.
      const bool is_gone = !is_same && is_same.error().code == ErrorCode::kNotFound;
      if (is_gone && turn < kMaxTurns) continue;
      if (!is_same && !is_gone) return is_same.error();
      if (is_gone || !*is_same) return AnotherIsThere(*known);
      return std::optional<storage::AddedFile>();
    }
    const Result<storage::AddedFile> added = service.catalogue.AddFile(
        flight_id, file, storage::Now(), known ? known->stored_name : std::string());
    if (added) return std::optional(*added);
    // Another request was faster.
    const bool came_between = added.error().code == ErrorCode::kPreconditionFailed;
    if (!came_between || turn == kMaxTurns) return added.error();
  }
}

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
    const std::int64_t bytes = upload_.bytes();
    if (sha256_ && digest_.Finish() != *sha256_) {
      return Problem(
          {ErrorCode::kDigestMismatch, "The bytes are not those that Content-Digest says. Send them again."},
          request_);
    }
    Result<std::string> stored = upload_.Finish();
    if (!stored) return Problem(stored.error(), request_);
    const StoredFile file{request_.Parameter("name"), *stored, bytes};
    Result<Response> kept = storage::IsArchiveName(file.name) ? KeepContent(file) : Keep(file);
    return kept ? *std::move(kept) : Problem(kept.error(), request_);
  }

 private:
  Result<Response> Keep(const StoredFile& file) {
    const std::string& flight_id = request_.Parameter("flight");
    const Result<std::optional<storage::AddedFile>> added = AddInItsPlace(service_, request_, file);
    if (!added) {
      service_.store.TakeBack(flight_id, file.stored_name, added.error());
      return added.error();
    }
    if (!*added) {
      service_.store.Remove(flight_id, file.stored_name);
      return JsonOf(200, FileJson(file));
    }
    incoming_.Kept(file.bytes);
    if ((*added)->replaced) {
      service_.store.Remove(flight_id, (*added)->replaced_stored_name);
      incoming_.Freed((*added)->replaced_bytes);
    }
    return JsonOf((*added)->replaced ? 200 : 201, FileJson(file));
  }

  // An archive's own name is there only until it is unpacked.
  Result<Response> KeepContent(const StoredFile& file) {
    const std::string& flight_id = request_.Parameter("flight");
    const Result<StoredFile> added = service_.catalogue.AddFileUnderFreeName(flight_id, file, storage::Now());
    if (!added) service_.store.TakeBack(flight_id, file.stored_name, added.error());
    if (!added) return added.error();
    incoming_.Kept(file.bytes);
    SKYQUILT_TRY_ASSIGN(const std::vector<FileOutcome> outcomes, UnpackOnly(service_, flight_id, *added));
    return JsonOf(201, {{"files", FileOutcomesJson(outcomes)}});
  }

  Service& service_;
  Request request_;
  storage::Upload upload_;
  IncomingBytes incoming_;
  std::optional<std::string> sha256_;
  Digest digest_{DigestAlgorithm::kSha256};
};

// The bytes of a body are the file: a part of one, or one that is packed, is none (RFC 9110 8.4, 14.5).
Result<void> CheckIsWholeFile(const Request& request) {
  if (request.headers.Has("Content-Range")) {
    return Error{
        ErrorCode::kInvalidArgument,
        "A part of a file cannot be put. Send the whole file, or in parts by tus, at /api/v1/uploads, "
        "as \"skyquilt upload\" and the page do."};
  }
  const std::string_view encoding = request.headers.Find("Content-Encoding");
  if (encoding.empty() || EqualsIgnoringCase(encoding, "identity")) return {};
  return Error{
      ErrorCode::kUnsupportedFormat,
      "The body is encoded (Content-Encoding). Send the file as it is; archives (.zip, .tar, .tar.gz) are "
      "unpacked."};
}

UploadBegun BeginPut(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckIsWholeFile(request));
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(storage::CheckFileName(request.Parameter("name")));
  SKYQUILT_TRY_ASSIGN(const bool is_known, service.catalogue.HasFlight(flight_id));
  if (!is_known) return Error{ErrorCode::kNotFound, "There is no such flight."};
  if (!storage::IsArchiveName(request.Parameter("name"))) {
    SKYQUILT_TRY_ASSIGN(const std::optional<StoredFile> there, FindInItsPlace(service, request));
    // Told before the bytes are sent where their number tells.
    const bool is_other = there && request.content_length &&
                          *request.content_length != static_cast<std::uint64_t>(there->bytes);
    if (is_other && !MayReplace(request)) return AnotherIsThere(*there);
  }
  SKYQUILT_TRY_ASSIGN(IncomingBytes incoming, IncomingBytes::Into(service, flight_id));
  SKYQUILT_TRY(incoming.CheckRoom(request.content_length));
  SKYQUILT_TRY_ASSIGN(
      storage::Upload upload,
      service.store.Begin(flight_id, static_cast<std::int64_t>(std::min<std::uint64_t>(
                                         request.content_length.value_or(0), storage::kMaxFileBytes + 1))));
  std::optional<std::string> sha256;
  if (request.headers.Has("Content-Digest")) {
    sha256 = Sha256OfContentDigest(request.headers.Find("Content-Digest"));
    if (!sha256) return Error{ErrorCode::kInvalidArgument, "Content-Digest has no sha-256 that can be read."};
  }
  return std::make_unique<PutFile>(service, request, std::move(upload), std::move(incoming),
                                   std::move(sha256));
}

Result<Response> ListFiles(Service& service, const Request& request) {
  SKYQUILT_TRY(RequireFlight(service, request.Parameter("flight")));
  SKYQUILT_TRY_ASSIGN(const std::vector<StoredFile> files,
                      service.catalogue.ListFiles(request.Parameter("flight")));
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const StoredFile& file : files) items.push_back(FileJson(file));
  return JsonOf(200, {{"files", items}});
}

Result<Response> DeleteFile(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  const Result<StoredFile> removed =
      service.db.Free([&] { return service.catalogue.RemoveFile(flight_id, request.Parameter("name")); });
  if (!removed) return removed.error();
  service.store.Remove(flight_id, removed->stored_name);
  service.db.FillReserve();
  return NoContent();
}

}  // namespace

void AddFileRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/files", On(service, ListFiles));
  router.AddUpload(Method::kPut, "/api/v1/flights/{flight}/files/{name}", On(service, BeginPut));
  router.Add(Method::kDelete, "/api/v1/flights/{flight}/files/{name}", On(service, DeleteFile));
}

}  // namespace skyquilt::api
