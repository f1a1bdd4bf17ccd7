#include "server/units/unit_heartbeat.h"

#include <chrono>
#include <utility>

#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

using storage::LeaseState;

// So that a cancelled job does not keep its workers for long.
constexpr std::chrono::seconds kRenewUnitEvery{2};

}  // namespace

UnitHeartbeat::UnitHeartbeat(storage::UnitQueue& units, storage::UnitLease lease,
                             const std::atomic<bool>& is_stopping, std::chrono::seconds unheard)
    : units_(units), lease_(std::move(lease)), is_stopping_(is_stopping), unheard_(unheard), thread_([this] {
        Beat();
      }) {}

UnitHeartbeat::~UnitHeartbeat() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  end_.notify_all();
  thread_.join();
}

bool UnitHeartbeat::IsCancelled() const { return is_stopping_ || state_ != LeaseState::kHeld; }

void UnitHeartbeat::Beat() {
  auto renewed = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!is_ended_) {
    end_.wait_for(lock, kRenewUnitEvery, [this] { return is_ended_; });
    if (is_ended_) return;
    lock.unlock();
    const auto now = std::chrono::steady_clock::now();
    const Result<LeaseState> state = units_.Renew(lease_, storage::Now());
    if (state) {
      renewed = now;
      if (*state != LeaseState::kHeld) state_ = *state;
    } else {
      // A busy or full database is no reason to stop, until the unit may have gone to another.
      LogFailure(lease_.job_id, "heartbeat", state.error().detail);
      if (now - renewed >= unheard_) state_ = LeaseState::kLost;
    }
    lock.lock();
  }
}

}  // namespace skyquilt::server
