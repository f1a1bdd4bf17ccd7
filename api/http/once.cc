#include "api/http/once.h"

#include <mutex>

#include "api/http/digest.h"
#include "api/http/responses.h"
#include "core/base/try.h"
#include "storage/catalogue/idempotent_answers.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kLongestKey = 255;

std::string RouteOf(const Request& request) {
  return std::string(MethodName(request.method)) + " " + request.path;
}

Response Replay(const storage::IdempotentAnswer& answer) {
  Response response = Json(answer.status, answer.body);
  if (!answer.location.empty()) response.headers.Add("Location", answer.location);
  response.headers.Add("Idempotency-Replayed", "true");
  return response;
}

Result<storage::IdempotencyKey> KeyOf(const Request& request) {
  std::string key(request.headers.Find("Idempotency-Key"));
  if (key.empty() || key.size() > kLongestKey) {
    return Error{ErrorCode::kInvalidArgument, "Idempotency-Key must be 1 to 255 characters."};
  }
  return storage::IdempotencyKey{request.owner, std::move(key), RouteOf(request)};
}

}  // namespace

Response OnceBy(Service& service, const Request& request, const std::string& fingerprint,
                const std::function<Result<Response>()>& carry_out) {
  if (!request.headers.Has("Idempotency-Key")) return Answered(carry_out(), request);
  const Result<storage::IdempotencyKey> key = KeyOf(request);
  if (!key) return Problem(key.error(), request);
  storage::IdempotentAnswers answers(service.db);
  const std::lock_guard lock(service.once_mutex);
  const auto known = answers.Find(*key, service.db.ages().Now());
  if (!known) return Problem(known.error(), request);
  if (*known && (*known)->fingerprint != fingerprint) {
    return Problem(
        {ErrorCode::kUnprocessable,
         "This Idempotency-Key was used for another request. Send this one under a key of its own."},
        request);
  }
  if (*known) return Replay(**known);
  Response response = Answered(carry_out(), request);
  // What was not done may be tried again: by then there may be room for it, or what it lacked.
  if (response.status >= 400) return response;
  // It is done, whether or not that can be kept: who heard of a failure would have it done again.
  (void)answers
      .Keep(*key,
            {fingerprint, response.status, std::string(response.headers.Find("Location")), response.body},
            service.db.ages().Now())
      .ok();
  return response;
}

Response Once(Service& service, const Request& request, std::string_view body,
              const std::function<Result<Response>()>& carry_out) {
  return OnceBy(service, request, RawDigestOf(DigestAlgorithm::kSha256, body), carry_out);
}

Result<bool> HasKeptAnswer(Service& service, const Request& request) {
  if (!request.headers.Has("Idempotency-Key")) return false;
  SKYQUILT_TRY_ASSIGN(const storage::IdempotencyKey key, KeyOf(request));
  SKYQUILT_TRY_ASSIGN(const auto known,
                      storage::IdempotentAnswers(service.db).Find(key, service.db.ages().Now()));
  return known.has_value();
}

}  // namespace skyquilt::api
