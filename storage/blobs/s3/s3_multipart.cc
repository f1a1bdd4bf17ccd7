// S3Client: objects that are put in parts.

#include "core/base/try.h"
#include "storage/blobs/s3/s3_client.h"

namespace skyquilt::storage {
namespace {

// A store puts the parts together before it answers.
constexpr std::chrono::seconds kCompletionPatience{300};

}  // namespace

Result<std::string> S3Client::BeginUpload(const std::string& key, const S3PutOptions& options) {
  Ask ask{"POST", key};
  ask.query = {{"uploads", ""}};
  ask.headers = {{"Content-Type", "application/octet-stream"}};
  if (!options.sha256.empty()) ask.headers.emplace_back("x-amz-meta-sha256", options.sha256);
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform(ask));
  return ParseUploadId(answer.body);
}

Result<UploadedPart> S3Client::PutPart(const std::string& key, const std::string& upload_id, int number,
                                       std::string_view bytes) {
  Ask ask{"PUT", key};
  ask.query = {{"partNumber", std::to_string(number)}, {"uploadId", upload_id}};
  ask.body = bytes;
  SKYQUILT_TRY_ASSIGN(const HttpAnswer answer, Perform(ask));
  UploadedPart part{number, answer.Header("etag"), static_cast<std::int64_t>(bytes.size())};
  if (part.etag.empty())
    return Error{ErrorCode::kCorrupt, "The store of objects took a part and gave it no tag.", key};
  return part;
}

Result<void> S3Client::Complete(const std::string& key, const std::string& upload_id,
                                const std::vector<UploadedPart>& parts, std::int64_t bytes) {
  const std::string xml = CompletionXml(parts);
  Ask ask{"POST", key};
  ask.query = {{"uploadId", upload_id}};
  ask.headers = {{"Content-Type", "application/xml"}};
  ask.body = xml;
  ask.stall_patience = kCompletionPatience;
  std::optional<Error> failure;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const Result<HttpAnswer> answer = Perform(ask);
    // The status is sent before the parts are joined: a 200 may still hold an error.
    const auto refusal = answer ? ParseRefusal(answer->body) : std::nullopt;
    if (answer && !refusal) return {};
    if (refusal) {
      failure = Error{ErrorCode::kUnavailable, "The store of objects could not put an upload together.",
                      key + ": " + refusal->code + " " + refusal->message};
      continue;
    }
    failure = answer.error();
    if (failure->code == ErrorCode::kNotFound) {
      // Completed before, and only the answer got lost.
      const Result<S3Object> there = Head(key);
      if (there && there->bytes == bytes) return {};
    }
    return *failure;
  }
  return *failure;
}

Result<void> S3Client::Abort(const std::string& key, const std::string& upload_id) {
  Ask ask{"DELETE", key};
  ask.query = {{"uploadId", upload_id}};
  const Result<HttpAnswer> answer = Perform(ask);
  if (answer || answer.error().code == ErrorCode::kNotFound) return {};
  return answer.error();
}

}  // namespace skyquilt::storage
