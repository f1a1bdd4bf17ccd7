// What a token may take: requests a minute, and bytes that its flights hold. Any thread. Errors:
// kRateLimited, kTooLarge, and the catalogue's.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "api/http_message.h"
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

// Counts the request. Bytes are refused before they are taken: by what the request says it brings.
Result<void> CheckLimits(Service& service, const storage::Token& token, const Request& request,
                         std::string_view pattern);

}  // namespace skyquilt::api
