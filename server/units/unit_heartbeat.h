// UnitHeartbeat: the Progress of a unit that a worker runs: renews the lease and notices cancellation, a lost
// lease and the end of the worker. How far the unit is, nobody asks: its job counts the units that are done.
// A thread of its own waits for the database. Any thread may report.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string_view>
#include <thread>

#include "core/base/progress.h"
#include "storage/jobs/unit_queue.h"

namespace skyquilt::server {

class UnitHeartbeat final : public Progress {
 public:
  // Not heard for `unheard`, it takes its lease for lost.
  UnitHeartbeat(storage::UnitQueue& units, storage::UnitLease lease, const std::atomic<bool>& is_stopping,
                std::chrono::seconds unheard);
  ~UnitHeartbeat() override;

  void BeginStage(std::string_view) override {}
  void Report(double, std::string_view) override {}
  bool IsCancelled() const override;

  storage::LeaseState lease_state() const { return state_; }

 private:
  void Beat();

  storage::UnitQueue& units_;
  const storage::UnitLease lease_;
  const std::atomic<bool>& is_stopping_;
  const std::chrono::seconds unheard_;
  std::atomic<storage::LeaseState> state_ = storage::LeaseState::kHeld;
  std::mutex mutex_;
  std::condition_variable end_;
  bool is_ended_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace skyquilt::server
