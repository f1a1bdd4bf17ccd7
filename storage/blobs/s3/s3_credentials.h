// CredentialSource: the keys with which requests to S3 are signed. Looked for in this order, and kept until
// five minutes before they end: AWS_ACCESS_KEY_ID with AWS_SECRET_ACCESS_KEY (and AWS_SESSION_TOKEN); the
// profile AWS_PROFILE ("default") of AWS_SHARED_CREDENTIALS_FILE (~/.aws/credentials); the container's
// service (AWS_CONTAINER_CREDENTIALS_RELATIVE_URI or ..._FULL_URI); the machine's role (IMDSv2, unless
// AWS_EC2_METADATA_DISABLED). Secrets are in no message and no log. Any thread. Errors: kForbidden, with a
// sentence that says where keys were looked for.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/blobs/s3/http_transfer.h"
#include "storage/blobs/s3/s3_settings.h"
#include "storage/blobs/s3/sign_request.h"

namespace skyquilt::storage {

class CredentialSource {
 public:
  explicit CredentialSource(Variable variable) : variable_(std::move(variable)) {}

  Result<S3Credentials> Get(std::chrono::system_clock::time_point now);
  // The store refused them: the next Get looks again, unless they are the environment's.
  void Forget();

 private:
  Result<S3Credentials> Look();
  Result<std::optional<S3Credentials>> FromFile() const;
  Result<std::optional<S3Credentials>> FromContainer();
  Result<std::optional<S3Credentials>> FromMachine();
  Result<std::string> Fetch(const std::string& method, const std::string& url, NamedValues headers);

  const Variable variable_;
  HttpTransfers transfers_;
  std::mutex mutex_;
  std::optional<S3Credentials> known_;
};

// One profile of a credentials file; absent where it has none. Pure.
std::optional<S3Credentials> CredentialsInFile(std::string_view text, std::string_view profile);
// What a credentials service answers, as JSON; absent where it is none. Pure.
std::optional<S3Credentials> CredentialsInAnswer(std::string_view json);
// `format`: as strptime has it. Absent: it is no such time, or none that the clock counts.
std::optional<std::chrono::system_clock::time_point> UtcOf(const std::string& text, const char* format);
// "2026-05-24T12:00:00Z".
std::optional<std::chrono::system_clock::time_point> ParseUtc(const std::string& text);
// A token is sent over http only to this machine and to the addresses that container services have.
bool IsContainerService(const std::string& url);

}  // namespace skyquilt::storage
