#include "api/auth/limits.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/service.h"

namespace skyquilt::api {
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

Result<void> CheckLimits(Service& service, const storage::Token& token) {
  if (!token.requests_per_minute ||
      service.rate_limiter.Take(token.id, *token.requests_per_minute, RateLimiter::Clock::now())) {
    return {};
  }
  return Error{ErrorCode::kRateLimited,
               fmt::format("This token may send {} requests a minute. Try again in a moment.",
                           *token.requests_per_minute),
               ""};
}

}  // namespace skyquilt::api
