#include "server/jobs/job_progress.h"

#include <algorithm>

#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

using storage::LeaseState;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBeat{250};
constexpr std::chrono::seconds kRenewEvery{3};
// No job begins so many stages between two beats; a process that was taken over may say it does.
constexpr std::size_t kMaxUntold = 32;

}  // namespace

StageShares UsualShares(JobKind kind) {
  switch (kind) {
    case JobKind::kImport:
      return {{"import", 0.95}, {"export", 0.05}};
    case JobKind::kUpright:
      return {{"read", 0.01},   {"check", 0.04},   {"pose", 0.01},    {"align", 0.06},
              {"ground", 0.01}, {"surface", 0.46}, {"plan", 0.01},    {"expose", 0.01},
              {"seam", 0.04},   {"render", 0.31},  {"measure", 0.01}, {"export", 0.03}};
    case JobKind::kWithHeights:
      return {{"read", 0.02},   {"check", 0.06},   {"pose", 0.01},   {"align", 0.11},
              {"ground", 0.01}, {"plan", 0.01},    {"expose", 0.01}, {"seam", 0.02},
              {"render", 0.14}, {"measure", 0.01}, {"export", 0.05}, {"surface", 0.55}};
    case JobKind::kUsual:
      break;
  }
  return {{"read", 0.04},   {"check", 0.15},   {"pose", 0.01},   {"align", 0.26},
          {"ground", 0.01}, {"plan", 0.01},    {"expose", 0.02}, {"seam", 0.04},
          {"render", 0.34}, {"measure", 0.02}, {"export", 0.10}};
}

StageShares SharesOf(const storage::Expectation& expectation) {
  StageShares shares;
  for (const auto& [stage, usual] : UsualShares()) {
    const auto measured = std::find_if(expectation.shares.begin(), expectation.shares.end(),
                                       [&name = stage](const auto& share) { return share.first == name; });
    shares.emplace_back(stage, measured == expectation.shares.end() ? 0.0 : measured->second);
  }
  return shares;
}

double WholeJobFraction(const StageShares& shares, std::string_view stage, double stage_fraction) {
  double before = 0.0;
  for (const auto& [name, share] : shares) {
    // The shares' sum is one but for rounding.
    if (name == stage) return std::min(1.0, before + share * std::clamp(stage_fraction, 0.0, 1.0));
    before += share;
  }
  return 0.0;
}

JobProgress::JobProgress(storage::JobQueue& queue, storage::Lease lease, const std::atomic<bool>& is_stopping,
                         StageShares shares, ProgressSpan span, std::chrono::seconds unheard)
    : queue_(queue),
      lease_(std::move(lease)),
      shares_(std::move(shares)),
      span_(span),
      unheard_(unheard),
      is_stopping_(is_stopping),
      thread_([this] { Beat(); }) {}

double JobProgress::FractionAt(std::string_view stage, double stage_fraction) const {
  return span_.from + (span_.to - span_.from) * WholeJobFraction(shares_, stage, stage_fraction);
}

void JobProgress::BeginStage(std::string_view stage) {
  const std::lock_guard lock(mutex_);
  latest_.stage = stage;
  latest_.message.clear();
  latest_.fraction = std::max(latest_.fraction, FractionAt(stage, 0.0));
  if (untold_.size() < kMaxUntold) {
    untold_.push_back(latest_);
  } else {
    untold_.back() = latest_;
  }
}

void JobProgress::Report(double fraction, std::string_view message) {
  const std::lock_guard lock(mutex_);
  latest_.message = message;
  latest_.fraction = std::max(latest_.fraction, FractionAt(latest_.stage, fraction));
  if (untold_.empty()) {
    untold_.push_back(latest_);
  } else {
    untold_.back() = latest_;
  }
}

bool JobProgress::IsCancelled() const { return is_stopping_ || state_ != LeaseState::kHeld; }

void JobProgress::Beat() {
  while (thread_.Rest(kBeat)) {
    std::unique_lock lock(mutex_);
    const std::vector<storage::JobProgress> untold = std::exchange(untold_, {});
    lock.unlock();
    const LeaseState state = TellQueue(untold);
    if (state != LeaseState::kHeld) state_ = state;
  }
}

LeaseState JobProgress::TellQueue(const std::vector<storage::JobProgress>& untold) {
  const auto asked = Clock::now();  // a call may wait for a database that is started again
  const bool is_due = asked - renewed_ >= kRenewEvery;
  Result<LeaseState> state = is_due ? queue_.Renew(lease_, storage::Now()) : queue_.LeaseStateOf(lease_);
  for (const storage::JobProgress& progress : untold) {
    if (!state || *state != LeaseState::kHeld) break;
    state = queue_.ReportProgress(lease_, progress);
  }
  if (state) {
    if (is_due) renewed_ = asked;
    return *state;
  }
  // A busy or full database is no reason to stop, until the lease may have gone to another.
  LogFailure(lease_.job_id, "heartbeat", state.error());
  return asked - renewed_ < unheard_ ? LeaseState::kHeld : LeaseState::kLost;
}

}  // namespace skyquilt::server
