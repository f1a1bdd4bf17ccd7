#include "api/http/responses.h"

#include <fmt/format.h>

#include <utility>

#include "api/http/etag.h"
#include "api/json/json_text.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

class Collector final : public BodySink {
 public:
  Collector(std::function<Response(std::string)> answer, std::size_t max_bytes)
      : answer_(std::move(answer)), max_bytes_(max_bytes) {}
  Result<void> Write(std::span<const std::uint8_t> bytes) override {
    if (body_.size() + bytes.size() > max_bytes_) {
      return Error{ErrorCode::kTooLarge, fmt::format("The body is longer than {} KiB.", max_bytes_ >> 10),
                   ""};
    }
    body_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return {};
  }
  Response Finish() override { return answer_(std::move(body_)); }

 private:
  std::function<Response(std::string)> answer_;
  std::size_t max_bytes_;
  std::string body_;
};

}  // namespace

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

Response NoContent() {
  Response response;
  response.status = 204;
  return response;
}

std::unique_ptr<BodySink> CollectBody(std::function<Response(std::string body)> answer,
                                      std::size_t max_bytes) {
  return std::make_unique<Collector>(std::move(answer), max_bytes);
}

Result<void> CheckId(const std::string& id, const char* what) {
  if (!storage::IsId(id)) return Error{ErrorCode::kNotFound, fmt::format("There is no such {}.", what), ""};
  return {};
}

bool IsJson(const Request& request) {
  const std::string_view type = request.headers.Find("Content-Type");
  return type.empty() || EqualsIgnoringCase(type.substr(0, type.find_first_of("; ")), "application/json");
}

}  // namespace skyquilt::api
