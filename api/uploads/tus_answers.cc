#include "api/uploads/tus_answers.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "api/http/problem.h"
#include "api/uploads/tus_headers.h"

namespace skyquilt::api {
namespace {

std::string HttpDate(storage::Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
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

}  // namespace skyquilt::api
