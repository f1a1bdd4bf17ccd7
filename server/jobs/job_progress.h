// JobProgress: the Progress of a job that a worker runs: writes stage and fraction to the queue (a few times
// per second: every stage that began, within reason, of each the newest fraction), renews the lease, and
// notices cancellation, a lost lease and the end of the worker. A thread of its own waits for the database;
// Report never does. Any thread may report.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "server/background_thread.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::server {

enum class JobKind {
  kUsual,
  kImport,       // takes over a map of others (import_file)
  kUpright,      // heights are matched before the map is drawn (surface)
  kWithHeights,  // and after it (heights)
};

// The share of each stage in a job's time, in the order they come.
using StageShares = std::vector<std::pair<std::string, double>>;
// Of a flight of some hundred photos, where none has been measured.
StageShares UsualShares(JobKind kind = JobKind::kUsual);
// As measured here.
StageShares SharesOf(const storage::Expectation& expectation);

// How much of a whole job lies behind when a stage is this far; a stage that is not known adds nothing.
double WholeJobFraction(const StageShares& shares, std::string_view stage, double stage_fraction);

// The part of the whole job that this worker does: where it begins and ends, 0..1.
struct ProgressSpan {
  double from = 0.0;
  double to = 1.0;
};

class JobProgress final : public Progress {
 public:
  // `is_stopping` is the worker's own wish to end; not heard for `unheard`, it takes its lease for lost.
  JobProgress(storage::JobQueue& queue, storage::Lease lease, const std::atomic<bool>& is_stopping,
              StageShares shares = UsualShares(), ProgressSpan span = {},
              std::chrono::seconds unheard = storage::kLeaseTime);

  void BeginStage(std::string_view stage) override;
  void Report(double fraction, std::string_view message) override;
  bool IsCancelled() const override;

  // Held: go on and publish. After the end of the work.
  storage::LeaseState lease_state() const { return state_; }

 private:
  double FractionAt(std::string_view stage, double stage_fraction) const;
  void Beat();
  storage::LeaseState TellQueue(const std::vector<storage::JobProgress>& untold);

  storage::JobQueue& queue_;
  const storage::Lease lease_;
  const StageShares shares_;
  const ProgressSpan span_;
  const std::chrono::seconds unheard_;
  const std::atomic<bool>& is_stopping_;
  std::atomic<storage::LeaseState> state_ = storage::LeaseState::kHeld;
  std::mutex mutex_;
  storage::JobProgress latest_;
  std::vector<storage::JobProgress> untold_;  // since the last beat, one of each stage, in their order
  std::chrono::steady_clock::time_point renewed_ = std::chrono::steady_clock::now();
  BackgroundThread thread_;
};

}  // namespace skyquilt::server
