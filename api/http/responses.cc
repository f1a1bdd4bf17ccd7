#include "api/http/responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "api/http/conditional.h"
#include "api/json/json_text.h"
#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_json.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

Response Document(int status, const char* kind, std::string_view detail, std::string_view instance,
                  std::string_view request_id, const std::optional<flight::Remark>& reason = std::nullopt) {
  nlohmann::ordered_json body;
  body["type"] = std::string("urn:skyquilt:problem:") + kind;
  body["title"] = ReasonOf(status);
  body["status"] = status;
  body["code"] = kind;
  body["detail"] = detail;
  if (reason) body["reason"] = flight::JsonOfRemark<nlohmann::ordered_json>(*reason);
  body["instance"] = instance;
  body["request_id"] = request_id;
  Response response;
  response.status = status;
  response.headers.Add("Content-Type", "application/problem+json");
  response.headers.Add("Cache-Control", "no-store");
  response.body = JsonText(body);
  return response;
}

class Collector final : public BodySink {
 public:
  Collector(Request request, BodyHandler answer, std::size_t max_bytes)
      : request_(std::move(request)), answer_(std::move(answer)), max_bytes_(max_bytes) {}
  Result<void> Write(std::span<const std::uint8_t> bytes) override {
    if (body_.size() + bytes.size() > max_bytes_) {
      return Error{ErrorCode::kTooLarge, fmt::format("The body is longer than {} KiB.", max_bytes_ >> 10)};
    }
    body_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return {};
  }
  Response Finish() override { return Answered(answer_(request_, body_), request_); }

 private:
  Request request_;
  BodyHandler answer_;
  std::size_t max_bytes_;
  std::string body_;
};

}  // namespace

int StatusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return 400;
    case ErrorCode::kUnprocessable:
    case ErrorCode::kCorrupt:
    case ErrorCode::kNoPosition:
    case ErrorCode::kDigestMismatch:
      return 422;
    case ErrorCode::kUnsupportedFormat:
      return 415;
    case ErrorCode::kNotFound:
      return 404;
    case ErrorCode::kConflict:
    case ErrorCode::kCancelled:
      return 409;
    case ErrorCode::kPreconditionFailed:
      return 412;
    case ErrorCode::kTooLarge:
      return 413;
    case ErrorCode::kOutOfSpace:
      return 507;
    case ErrorCode::kUnauthorized:
      return 401;
    case ErrorCode::kForbidden:
      return 403;
    case ErrorCode::kMethodNotAllowed:
      return 405;
    case ErrorCode::kNotAcceptable:
      return 406;
    case ErrorCode::kLengthRequired:
      return 411;
    case ErrorCode::kRangeNotSatisfiable:
      return 416;
    case ErrorCode::kRateLimited:
      return 429;
    case ErrorCode::kTimeout:
      return 408;
    case ErrorCode::kUnavailable:
      return 503;
    case ErrorCode::kNotImplemented:
      return 501;
    case ErrorCode::kIo:
    case ErrorCode::kInternal:
      return 500;
  }
  SKYQUILT_CHECK(false, "an error kind outside the list");
}

const char* ReasonOf(int status) {
  static constexpr std::pair<int, const char*> kReasons[] = {{100, "Continue"},
                                                             {200, "OK"},
                                                             {201, "Created"},
                                                             {202, "Accepted"},
                                                             {204, "No Content"},
                                                             {206, "Partial Content"},
                                                             {304, "Not Modified"},
                                                             {308, "Permanent Redirect"},
                                                             {400, "Bad Request"},
                                                             {401, "Unauthorized"},
                                                             {403, "Forbidden"},
                                                             {404, "Not Found"},
                                                             {405, "Method Not Allowed"},
                                                             {406, "Not Acceptable"},
                                                             {408, "Request Timeout"},
                                                             {409, "Conflict"},
                                                             {411, "Length Required"},
                                                             {412, "Precondition Failed"},
                                                             {413, "Content Too Large"},
                                                             {414, "URI Too Long"},
                                                             {415, "Unsupported Media Type"},
                                                             {416, "Range Not Satisfiable"},
                                                             {417, "Expectation Failed"},
                                                             {421, "Misdirected Request"},
                                                             {422, "Unprocessable Content"},
                                                             {429, "Too Many Requests"},
                                                             {460, "Checksum Mismatch"},
                                                             {431, "Request Header Fields Too Large"},
                                                             {500, "Internal Server Error"},
                                                             {501, "Not Implemented"},
                                                             {503, "Service Unavailable"},
                                                             {505, "HTTP Version Not Supported"},
                                                             {507, "Insufficient Storage"}};
  const auto* found = std::find_if(std::begin(kReasons), std::end(kReasons),
                                   [&](const auto& reason) { return reason.first == status; });
  return found == std::end(kReasons) ? "Unknown" : found->second;
}

Response Problem(const Error& error, std::string_view instance, std::string_view request_id) {
  const std::string kind(ErrorCodeName(error.code));
  std::optional<flight::Remark> reason;
  if (flight::HasReason(error)) reason = flight::WhyOf(error);
  Response response =
      Document(StatusOf(error.code), kind.c_str(), error.message, instance, request_id, reason);
  if (error.code == ErrorCode::kUnavailable || error.code == ErrorCode::kRateLimited) {
    response.headers.Add("Retry-After", "2");
  }
  response.for_log = error.message + " " + error.detail;
  return response;
}

Response ProblemWithStatus(int status, std::string_view detail, std::string_view instance,
                           std::string_view request_id) {
  return Document(status, "http", detail, instance, request_id);
}

Response Answered(Result<Response> answer, const Request& request) {
  return answer ? *std::move(answer) : Problem(answer.error(), request);
}

Response Text(int status, std::string body, std::string content_type) {
  Response response;
  response.status = status;
  response.headers.Add("Content-Type", std::move(content_type));
  response.body = std::move(body);
  return response;
}

Response Tagged(const Request& request, Response response) {
  const std::string etag = StrongEtag(std::hash<std::string>()(response.body));
  response.headers.Add("ETag", etag);
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    response.body.clear();
  }
  return response;
}

Response Json(int status, std::string body) {
  Response response = Text(status, std::move(body), "application/json");
  response.headers.Add("Cache-Control", "no-store");
  return response;
}

Response JsonOf(int status, const nlohmann::ordered_json& value) { return Json(status, JsonText(value)); }

Response NoCache(Response response) {
  response.headers.Add("Cache-Control", "no-cache");
  return response;
}

Response NoCacheJson(const nlohmann::ordered_json& document, const char* type) {
  return NoCache(Text(200, JsonText(document), type));
}

Response Xml(std::string body, std::string content_type) {
  constexpr const char* kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  return NoCache(Text(200, kHead + std::move(body), std::move(content_type)));
}

Response NoContent() {
  Response response;
  response.status = 204;
  return response;
}

std::unique_ptr<BodySink> CollectBody(const Request& request, BodyHandler answer, std::size_t max_bytes) {
  return std::make_unique<Collector>(request, std::move(answer), max_bytes);
}

Result<void> CheckId(const std::string& id, const char* what) {
  if (!storage::IsId(id)) return Error{ErrorCode::kNotFound, fmt::format("There is no such {}.", what)};
  return {};
}

bool IsJson(const Request& request) {
  const std::string_view type = request.headers.Find("Content-Type");
  return type.empty() || EqualsIgnoringCase(type.substr(0, type.find_first_of("; ")), "application/json");
}

}  // namespace skyquilt::api
