#include "storage/blobs/s3/s3_credentials.h"

#include <fmt/format.h>

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

using Json = nlohmann::json;
constexpr std::chrono::minutes kRefreshBefore{5};
constexpr std::chrono::milliseconds kServicePatience{1'000};
constexpr std::size_t kMaxServiceAnswer = std::size_t{64} << 10;
constexpr std::size_t kMaxCredentialsFile = std::size_t{1} << 20;
constexpr const char* kMachineService = "http://169.254.169.254";
constexpr const char* kContainerService = "http://169.254.170.2";

std::string ReadBounded(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxCredentialsFile, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

std::optional<S3Credentials> CredentialsInFile(std::string_view text, std::string_view profile) {
  S3Credentials credentials;
  bool is_in_profile = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = Trim(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with('[') && line.ends_with(']')) {
      std::string_view name = Trim(line.substr(1, line.size() - 2));
      if (name.starts_with("profile ")) name = Trim(name.substr(8));
      is_in_profile = name == profile;
    }
    const std::size_t equals = line.find('=');
    if (!is_in_profile || line.starts_with('#') || line.starts_with(';') || equals == std::string_view::npos)
      continue;
    const std::string_view name = Trim(line.substr(0, equals));
    const std::string value(Trim(line.substr(equals + 1)));
    if (name == "aws_access_key_id") credentials.access_key = value;
    if (name == "aws_secret_access_key") credentials.secret_key = value;
    if (name == "aws_session_token") credentials.session_token = value;
  }
  if (credentials.access_key.empty() || credentials.secret_key.empty()) return std::nullopt;
  return credentials;
}

std::optional<std::chrono::system_clock::time_point> UtcOf(const std::string& text, const char* format) {
  std::tm utc{};
  if (strptime(text.c_str(), format, &utc) == nullptr) return std::nullopt;
  // The clock counts nanoseconds in 64 bits: it ends in 2262.
  if (utc.tm_year < 70 || utc.tm_year > 300) return std::nullopt;
  return std::chrono::system_clock::from_time_t(timegm(&utc));
}

std::optional<std::chrono::system_clock::time_point> ParseUtc(const std::string& text) {
  return text.ends_with('Z') ? UtcOf(text, "%Y-%m-%dT%H:%M:%S") : std::nullopt;
}

std::optional<S3Credentials> CredentialsInAnswer(std::string_view text) {
  const Json json = ParseJson(text);
  if (!json.is_object()) return std::nullopt;
  const auto text_of = [&](const char* name) { return TextIn(json, name).value_or(""); };
  S3Credentials credentials{text_of("AccessKeyId"), text_of("SecretAccessKey"), text_of("Token"), {}};
  const auto expires = ParseUtc(text_of("Expiration"));
  if (credentials.access_key.empty() || credentials.secret_key.empty() || !expires) return std::nullopt;
  credentials.expires = *expires;
  return credentials;
}

bool IsContainerService(const std::string& url) {
  if (url.starts_with("https://")) return true;
  const std::size_t begin = std::string_view("http://").size();
  if (!url.starts_with("http://")) return false;
  std::string host = url.substr(begin, url.find('/', begin) - begin);
  if (host.find('@') != std::string::npos) return false;
  if (!host.starts_with('[')) host = host.substr(0, host.find(':'));
  return host == "localhost" || host == "169.254.170.2" || host == "169.254.170.23" ||
         host.starts_with("[::1]") ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

Result<std::string> CredentialSource::Fetch(const std::string& method, const std::string& url,
                                            NamedValues headers) {
  HttpExchange exchange;
  exchange.method = method;
  exchange.url = url;
  exchange.headers = std::move(headers);
  exchange.max_answer_bytes = kMaxServiceAnswer;
  exchange.connect_patience = kServicePatience;
  SKYQUILT_TRY_ASSIGN(HttpAnswer answer, transfers_.Perform(exchange));
  if (!answer.IsGood())
    return Error{ErrorCode::kUnavailable, fmt::format("{} answered {}.", url, answer.status), ""};
  return std::move(answer.body);
}

Result<std::optional<S3Credentials>> CredentialSource::FromFile() const {
  std::filesystem::path path = variable_("AWS_SHARED_CREDENTIALS_FILE");
  if (path.empty() && !variable_("HOME").empty())
    path = std::filesystem::path(variable_("HOME")) / ".aws" / "credentials";
  const std::string named = variable_("AWS_PROFILE");
  const std::string profile = named.empty() ? "default" : named;
  std::optional<S3Credentials> credentials =
      CredentialsInFile(path.empty() ? "" : ReadBounded(path), profile);
  if (!credentials && !named.empty()) {
    return Error{ErrorCode::kForbidden,
                 fmt::format("The profile \"{}\" of AWS_PROFILE is not in {}, or has no keys there.", profile,
                             path.string()),
                 ""};
  }
  return credentials;
}

Result<std::optional<S3Credentials>> CredentialSource::FromContainer() {
  const std::string relative = variable_("AWS_CONTAINER_CREDENTIALS_RELATIVE_URI");
  const std::string full = variable_("AWS_CONTAINER_CREDENTIALS_FULL_URI");
  if (relative.empty() && full.empty()) return std::optional<S3Credentials>();
  const std::string url = relative.empty() ? full : kContainerService + relative;
  if (!IsContainerService(url)) {
    return Error{ErrorCode::kForbidden,
                 "AWS_CONTAINER_CREDENTIALS_FULL_URI names a host that keys are not asked of without https.",
                 ""};
  }
  std::string token = variable_("AWS_CONTAINER_AUTHORIZATION_TOKEN");
  if (const std::string file = variable_("AWS_CONTAINER_AUTHORIZATION_TOKEN_FILE"); !file.empty()) {
    token = ReadBounded(file);
    while (token.ends_with('\n') || token.ends_with('\r')) token.pop_back();
  }
  NamedValues headers;
  if (!token.empty()) headers.emplace_back("Authorization", token);
  SKYQUILT_TRY_ASSIGN(const std::string answer, Fetch("GET", url, std::move(headers)));
  std::optional<S3Credentials> credentials = CredentialsInAnswer(answer);
  if (!credentials) return Error{ErrorCode::kUnavailable, "The container's service answered no keys.", ""};
  return credentials;
}

Result<std::optional<S3Credentials>> CredentialSource::FromMachine() {
  if (variable_("AWS_EC2_METADATA_DISABLED") == "true") return std::optional<S3Credentials>();
  std::string service = variable_("AWS_EC2_METADATA_SERVICE_ENDPOINT");
  if (service.empty()) service = kMachineService;
  while (service.ends_with('/')) service.pop_back();
  const Result<std::string> token =
      Fetch("PUT", service + "/latest/api/token", {{"X-aws-ec2-metadata-token-ttl-seconds", "21600"}});
  if (!token) return std::optional<S3Credentials>();  // no machine of such a service
  const NamedValues headers = {{"X-aws-ec2-metadata-token", *token}};
  const std::string path = service + "/latest/meta-data/iam/security-credentials/";
  SKYQUILT_TRY_ASSIGN(std::string role, Fetch("GET", path, headers));
  role = role.substr(0, role.find_first_of("\r\n"));
  SKYQUILT_TRY_ASSIGN(const std::string answer, Fetch("GET", path + UriEncode(role, false), headers));
  std::optional<S3Credentials> credentials = CredentialsInAnswer(answer);
  if (!credentials) return Error{ErrorCode::kUnavailable, "The machine's role has no keys now.", role};
  return credentials;
}

Result<S3Credentials> CredentialSource::Look() {
  const S3Credentials given{
      variable_("AWS_ACCESS_KEY_ID"), variable_("AWS_SECRET_ACCESS_KEY"), variable_("AWS_SESSION_TOKEN"), {}};
  if (!given.access_key.empty() && !given.secret_key.empty()) return given;
  SKYQUILT_TRY_ASSIGN(std::optional<S3Credentials> found, FromFile());
  if (found) return *std::move(found);
  SKYQUILT_TRY_ASSIGN(found, FromContainer());
  if (found) return *std::move(found);
  SKYQUILT_TRY_ASSIGN(found, FromMachine());
  if (found) return *std::move(found);
  return Error{ErrorCode::kForbidden,
               "There are no keys for S3: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, name a profile of "
               "~/.aws/credentials with AWS_PROFILE, or give this machine a role.",
               ""};
}

Result<S3Credentials> CredentialSource::Get(std::chrono::system_clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const bool lasts = known_ && (known_->expires == std::chrono::system_clock::time_point() ||
                                known_->expires - kRefreshBefore > now);
  if (lasts) return *known_;
  Result<S3Credentials> looked = Look();
  // Those that are known still serve for minutes while their source is away.
  if (!looked && known_ && known_->expires > now) return *known_;
  if (!looked) return looked.error();
  known_ = *looked;
  return looked;
}

void CredentialSource::Forget() {
  const std::lock_guard lock(mutex_);
  known_.reset();
}

}  // namespace skyquilt::storage
