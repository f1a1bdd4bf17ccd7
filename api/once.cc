#include "api/once.h"

#include <mutex>
#include <string>

#include "api/digest.h"
#include "api/problem.h"
#include "api/responses.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kLongestKey = 255;

std::string RouteOf(const Request& request) {
  return std::string(MethodName(request.method)) + " " + request.path;
}

std::string FingerprintOf(std::string_view body) {
  Digest digest(DigestAlgorithm::kSha256);
  digest.Add({reinterpret_cast<const std::uint8_t*>(body.data()), body.size()});
  return digest.Finish();
}

Response Replay(const storage::IdempotentAnswer& answer) {
  Response response = Json(answer.status, answer.body);
  if (!answer.location.empty()) response.headers.Add("Location", answer.location);
  response.headers.Add("Idempotency-Replayed", "true");
  return response;
}

Result<std::string> KeyOf(const Request& request) {
  std::string key(request.headers.Find("Idempotency-Key"));
  if (key.empty() || key.size() > kLongestKey) {
    return Error{ErrorCode::kInvalidArgument, "Idempotency-Key must be 1 to 255 characters.", ""};
  }
  return key;
}

Result<void> Keep(Service& service, const std::string& key, const Request& request, std::string_view body,
                  const Response& response) {
  // What the machine could not do may be tried again.
  if (response.status >= 500) return {};
  return service.idempotent_answers.Keep(
      key, RouteOf(request),
      {FingerprintOf(body), response.status, std::string(response.headers.Find("Location")), response.body},
      service.db.ages().Now());
}

}  // namespace

Response Once(Service& service, const Request& request, std::string_view body,
              const std::function<Response()>& carry_out) {
  if (!request.headers.Has("Idempotency-Key")) return carry_out();
  const Result<std::string> key = KeyOf(request);
  if (!key) return Problem(key.error(), request);
  const std::lock_guard lock(service.once_mutex);
  const auto known = service.idempotent_answers.Find(*key, RouteOf(request), service.db.ages().Now());
  if (!known) return Problem(known.error(), request);
  if (*known && (*known)->fingerprint != FingerprintOf(body)) {
    return Problem({ErrorCode::kUnprocessable, "This Idempotency-Key was used for another request.", ""},
                   request);
  }
  if (*known) return Replay(**known);
  Response response = carry_out();
  const Result<void> kept = Keep(service, *key, request, body, response);
  return kept ? std::move(response) : Problem(kept.error(), request);
}

std::optional<Response> KeptAnswer(Service& service, const Request& request) {
  if (!request.headers.Has("Idempotency-Key")) return std::nullopt;
  const Result<std::string> key = KeyOf(request);
  if (!key) return Problem(key.error(), request);
  const auto known = service.idempotent_answers.Find(*key, RouteOf(request), service.db.ages().Now());
  if (!known) return Problem(known.error(), request);
  if (!*known) return std::nullopt;
  return Replay(**known);
}

void KeepAnswer(Service& service, const Request& request, const Response& response) {
  const Result<std::string> key = KeyOf(request);
  // An answer that could not be kept is lost to a second try, not to the first.
  if (key) (void)Keep(service, *key, request, "", response).ok();
}

}  // namespace skyquilt::api
