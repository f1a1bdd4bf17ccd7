#include "api/auth/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "api/service.h"

namespace skyquilt::api {
namespace {

constexpr std::string_view kBringsFiles[] = {"/api/v1/flights",
                                             "/api/v1/flights/{flight}/files",
                                             "/api/v1/flights/{flight}/files/{name}",
                                             "/api/v1/uploads",
                                             "/task/new",
                                             "/task/new/upload/{uuid}"};

bool BringsFiles(const Request& request, std::string_view pattern) {
  const bool has_body = request.method == Method::kPost || request.method == Method::kPut;
  return has_body &&
         std::find(std::begin(kBringsFiles), std::end(kBringsFiles), pattern) != std::end(kBringsFiles);
}

// A resumable upload says at its creation what will come; the pieces are not counted again.
std::int64_t BroughtBytes(const Request& request) {
  const std::string_view declared = request.headers.Find("Upload-Length");
  std::int64_t bytes = 0;
  std::from_chars(declared.data(), declared.data() + declared.size(), bytes);
  return std::max(bytes, static_cast<std::int64_t>(request.content_length.value_or(0)));
}

}  // namespace

bool RateLimiter::Take(const std::string& token_id, std::int64_t a_minute, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  const auto most = static_cast<double>(a_minute);
  const auto [found, is_new] = buckets_.try_emplace(token_id, Bucket{most, now});
  Bucket& bucket = found->second;
  const double passed_s = std::chrono::duration<double>(now - bucket.filled).count();
  bucket.left = std::min(most, bucket.left + std::max(0.0, passed_s) * most / 60.0);
  bucket.filled = now;
  if (bucket.left < 1.0) return false;
  bucket.left -= 1.0;
  return true;
}

Result<void> CheckLimits(Service& service, const storage::Token& token, const Request& request,
                         std::string_view pattern) {
  if (token.requests_per_minute &&
      !service.rate_limiter.Take(token.id, *token.requests_per_minute, RateLimiter::Clock::now())) {
    return Error{ErrorCode::kRateLimited,
                 fmt::format("This token may send {} requests a minute. Try again in a moment.",
                             *token.requests_per_minute),
                 ""};
  }
  if (!token.most_bytes || !BringsFiles(request, pattern)) return {};
  const Result<std::int64_t> held = service.catalogue.BytesOf(token.id);
  if (!held) return held.error();
  if (*held + BroughtBytes(request) <= *token.most_bytes) return {};
  return Error{
      ErrorCode::kTooLarge,
      fmt::format(
          "The flights of this token hold {:.2f} of {:.2f} GB; this would be more. Delete a flight, or "
          "ask the server's operator for room.",
          static_cast<double>(*held) / 1e9, static_cast<double>(*token.most_bytes) / 1e9),
      ""};
}

}  // namespace skyquilt::api
