// Request rate of a token: requests per minute. (The bytes that its flights may hold are in api/auth/quota.)
// Any thread. Errors: kRateLimited.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "core/base/result.h"

namespace skyquilt::storage {
struct Token;
}

namespace skyquilt::api {

struct Service;

// A bucket for each token: it holds what a minute allows, and fills again as time goes.
class RateLimiter {
 public:
  using Clock = std::chrono::steady_clock;
  bool Take(const std::string& token_id, std::int64_t a_minute, Clock::time_point now);

 private:
  struct Bucket {
    double left = 0.0;
    Clock::time_point filled;
  };
  std::mutex mutex_;
  std::map<std::string, Bucket> buckets_;  // as many as there are tokens
};

// Counts one request.
Result<void> CheckLimits(Service& service, const storage::Token& token);

}  // namespace skyquilt::api
