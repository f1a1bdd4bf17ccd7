// How much a token may take: requests per minute, and the bytes that its flights may hold (token add
// --most-gb), enforced while bytes arrive, whichever upload route they take: neither an upload without a
// length nor several at once can exceed it. Any thread; one IncomingBytes is used by one thread at a time.
// Errors: kRateLimited, kTooLarge (the quota), kNotFound (no such flight), and the catalogue's.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
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

// Per owner, what the catalogue held when it was last read and what is being received. A deletion may be
// missing from it, an addition never is, and the catalogue is read again before anything is refused.
class ByteLedger {
 private:
  friend class IncomingBytes;
  struct Account {
    std::optional<std::int64_t> held;  // by the catalogue; absent: not asked yet
    std::int64_t on_the_way = 0;
  };
  std::mutex mutex_;
  std::map<std::string, Account> accounts_;  // by token id; only of tokens with a quota
};

// What one request brings. Counted from Take on; given back at its end, but for what was kept.
class IncomingBytes {
 public:
  // For the flights of a token (empty: of nobody, who has no quota), or of whom a flight belongs to.
  static Result<IncomingBytes> For(Service& service, const std::string& owner);
  static Result<IncomingBytes> Into(Service& service, const std::string& flight_id);
  ~IncomingBytes();
  IncomingBytes(IncomingBytes&& other) noexcept;
  IncomingBytes& operator=(IncomingBytes&&) = delete;
  IncomingBytes(const IncomingBytes&) = delete;

  // Before they are written.
  Result<void> Take(std::int64_t bytes);
  // Of those taken, what the catalogue has by now.
  void Kept(std::int64_t bytes);
  // What the catalogue had and has no more.
  void Freed(std::int64_t bytes);
  // How many bytes could be taken now; absent: there is no quota.
  Result<std::optional<std::int64_t>> Room() const;
  // Refuses a body that says that it is longer, before it is sent.
  Result<void> CheckRoom(std::optional<std::uint64_t> content_length) const;
  Error Refusal() const;  // why no more are taken

 private:
  IncomingBytes(Service& service, std::string owner) : service_(&service), owner_(std::move(owner)) {}
  // The caller holds the ledger's mutex.
  Result<void> RefreshHeld() const;

  Service* service_;
  std::string owner_;
  std::string token_name_;
  std::optional<std::int64_t> max_bytes_;
  std::int64_t taken_ = 0;  // and not kept
};

}  // namespace skyquilt::api
