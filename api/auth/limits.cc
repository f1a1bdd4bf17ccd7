#include "api/auth/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "api/service.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

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
                           *token.requests_per_minute)};
}

namespace {

// "9.8 kB", "2.50 GB"
std::string Readable(std::int64_t bytes) {
  const auto size = static_cast<double>(bytes);
  if (size < 1e6) return fmt::format("{:.1f} kB", size / 1e3);
  if (size < 1e9) return fmt::format("{:.1f} MB", size / 1e6);
  return fmt::format("{:.2f} GB", size / 1e9);
}

}  // namespace

Result<IncomingBytes> IncomingBytes::For(Service& service, const std::string& owner) {
  IncomingBytes incoming(service, owner);
  if (owner.empty()) return incoming;
  SKYQUILT_TRY_ASSIGN(const auto known, service.tokens.Known());
  for (const storage::Token& token : known->tokens) {
    if (token.id != owner) continue;
    incoming.token_name_ = token.name;
    incoming.max_bytes_ = token.max_bytes;
  }
  return incoming;
}

Result<IncomingBytes> IncomingBytes::Into(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::string owner, service.catalogue.OwnerOf(flight_id));
  return For(service, owner);
}

IncomingBytes::IncomingBytes(IncomingBytes&& other) noexcept
    : service_(other.service_),
      owner_(std::move(other.owner_)),
      token_name_(std::move(other.token_name_)),
      max_bytes_(std::exchange(other.max_bytes_, std::nullopt)),
      taken_(std::exchange(other.taken_, 0)) {}

IncomingBytes::~IncomingBytes() {
  if (!max_bytes_ || taken_ == 0) return;
  ByteLedger& ledger = service_->quotas;
  const std::lock_guard lock(ledger.mutex_);
  ledger.accounts_[owner_].on_the_way -= taken_;
}

Result<void> IncomingBytes::RefreshHeld() const {
  SKYQUILT_TRY_ASSIGN(const std::int64_t held, service_->catalogue.BytesOf(owner_));
  service_->quotas.accounts_[owner_].held = held;
  return {};
}

Result<void> IncomingBytes::Take(std::int64_t bytes) {
  if (!max_bytes_) return {};
  ByteLedger& ledger = service_->quotas;
  const std::lock_guard lock(ledger.mutex_);
  ByteLedger::Account& account = ledger.accounts_[owner_];
  const auto fits = [&] { return account.held && *account.held + account.on_the_way + bytes <= *max_bytes_; };
  if (!fits()) {
    SKYQUILT_TRY(RefreshHeld());
  }
  if (!fits()) return Refusal();
  account.on_the_way += bytes;
  taken_ += bytes;
  return {};
}

void IncomingBytes::Kept(std::int64_t bytes) {
  if (!max_bytes_) return;
  const std::int64_t kept = std::min(bytes, taken_);
  ByteLedger& ledger = service_->quotas;
  const std::lock_guard lock(ledger.mutex_);
  ByteLedger::Account& account = ledger.accounts_[owner_];
  account.on_the_way -= kept;
  taken_ -= kept;
  if (account.held) *account.held += kept;
}

void IncomingBytes::Freed(std::int64_t bytes) {
  if (!max_bytes_) return;
  ByteLedger& ledger = service_->quotas;
  const std::lock_guard lock(ledger.mutex_);
  ByteLedger::Account& account = ledger.accounts_[owner_];
  if (account.held) *account.held = std::max<std::int64_t>(0, *account.held - bytes);
}

Result<std::optional<std::int64_t>> IncomingBytes::Room() const {
  if (!max_bytes_) return std::optional<std::int64_t>();
  ByteLedger& ledger = service_->quotas;
  const std::lock_guard lock(ledger.mutex_);
  SKYQUILT_TRY(RefreshHeld());
  const ByteLedger::Account& account = ledger.accounts_[owner_];
  return std::optional(std::max<std::int64_t>(0, *max_bytes_ - *account.held - account.on_the_way));
}

Result<void> IncomingBytes::CheckRoom(std::optional<std::uint64_t> content_length) const {
  SKYQUILT_TRY_ASSIGN(const std::optional<std::int64_t> room, Room());
  if (room && content_length.value_or(0) > static_cast<std::uint64_t>(*room)) return Refusal();
  return {};
}

Error IncomingBytes::Refusal() const {
  return flight::Because(
      ErrorCode::kTooLarge,
      {flight::RemarkCode::kFailQuota, {{"token", token_name_}, {"room", Readable(max_bytes_.value_or(0))}}});
}

}  // namespace skyquilt::api
