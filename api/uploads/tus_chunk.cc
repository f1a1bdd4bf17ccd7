#include "api/uploads/tus_chunk.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <utility>

#include "api/http/responses.h"
#include "api/uploads/tus_headers.h"
#include "api/uploads/unpack.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

std::string HttpDate(storage::Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
}

using storage::SpooledUpload;

constexpr int kChecksumMismatch = 460;  // tus' own
constexpr const char* kChunkType = "application/offset+octet-stream";

// Bytes of one request, behind what the upload has.
class Chunk final : public BodySink {
 public:
  Chunk(Service& service, Request request, std::unique_ptr<storage::UploadSpool::Append> append,
        std::optional<TusChecksum> checksum, std::optional<IncomingBytes> incoming, TusChunkAnswer answer)
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
      return RefuseTus(kChecksumMismatch,
                       "The checksum is another. Nothing of this request was kept: send it again.", request_);
    }
    const Result<SpooledUpload> upload = append_->Commit(service_.db.ages().Now());
    CountSaved();
    if (!upload) return RefuseTus(upload.error(), request_);
    const Result<void> unpacked = UnpackUpload(service_, *upload);
    return unpacked ? answer_(*upload) : RefuseTus(unpacked.error(), request_);
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
  TusChunkAnswer answer_;
};

Result<std::optional<TusChecksum>> ChecksumOf(const Request& request) {
  if (!request.headers.Has("Upload-Checksum")) return std::optional<TusChecksum>();
  std::optional<TusChecksum> checksum = ParseTusChecksum(request.headers.Find("Upload-Checksum"));
  if (!checksum) {
    return Error{
        ErrorCode::kInvalidArgument,
        "Upload-Checksum (the extension checksum) must be sha1 or sha256 with its digest in base64."};
  }
  return checksum;
}

}  // namespace

Response TusAnswer(Response response) {
  response.headers.Add("Tus-Resumable", kTusVersion);
  return response;
}

Response RefuseTus(const Error& error, const Request& request) { return TusAnswer(Problem(error, request)); }

Response RefuseTus(int status, std::string_view why, const Request& request) {
  return TusAnswer(ProblemWithStatus(status, why, request.path, request.request_id));
}

void DescribeTus(const Service& service, const storage::SpooledUpload& upload, Response& response) {
  response.headers.Add("Upload-Offset", std::to_string(upload.offset));
  if (!upload.is_done)
    response.headers.Add("Upload-Expires", HttpDate(service.db.ages().OnTheWall(upload.expires)));
  if (!upload.concat.empty()) response.headers.Add("Upload-Concat", upload.concat);
}

Result<void> UnpackUpload(Service& service, const SpooledUpload& upload) {
  if (!upload.file) return {};
  const auto unpacked = UnpackOnly(service, upload.flight_id, *upload.file);
  if (unpacked) return {};
  (void)service.spool.Remove(upload.id, service.db.ages().Now()).ok();  // else until it expires
  return unpacked.error();
}

std::optional<Response> CheckTusVersion(const Request& request) {
  if (request.headers.Find("Tus-Resumable") == kTusVersion) return std::nullopt;
  Response response = RefuseTus(412, "Say Tus-Resumable: 1.0.0.", request);
  response.headers.Add("Tus-Version", kTusVersion);
  return response;
}

std::optional<Response> CheckTusOwner(const Service& service, const Request& request) {
  if (auto refused = CheckTusVersion(request)) return refused;
  if (request.is_admin) return std::nullopt;
  const Result<void> checked =
      service.spool.CheckOwner(request.Parameter("upload"), request.owner, service.db.ages().Now());
  if (checked) return std::nullopt;
  return RefuseTus(checked.error(), request);
}

Result<IncomingBytes> TusBytes(Service& service, const std::string& flight_id, const std::string& owner) {
  return flight_id.empty() ? IncomingBytes::For(service, owner) : IncomingBytes::Into(service, flight_id);
}

bool IsTusChunk(const Request& request) {
  return EqualsIgnoringCase(request.headers.Find("Content-Type"), kChunkType);
}

UploadBegun BeginTusChunk(Service& service, const Request& request, const std::string& id,
                          std::int64_t offset, TusChunkAnswer answer) {
  SKYQUILT_TRY_ASSIGN(const std::optional<TusChecksum> checksum, ChecksumOf(request));
  const storage::Time now = service.db.ages().Now();
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<storage::UploadSpool::Append> append,
                      service.spool.Begin(id, offset, checksum.has_value(), now));
  if (append->is_joined()) {
    return RefuseTus(
        403, "This upload was put together from its parts (the extension concatenation): it takes no bytes.",
        request);
  }
  std::optional<IncomingBytes> incoming;
  if (!append->has_length()) {
    SKYQUILT_TRY_ASSIGN(IncomingBytes counted, TusBytes(service, append->flight_id(), append->owner()));
    incoming.emplace(std::move(counted));
  }
  return std::make_unique<Chunk>(service, request, std::move(append), checksum, std::move(incoming),
                                 std::move(answer));
}

}  // namespace skyquilt::api
