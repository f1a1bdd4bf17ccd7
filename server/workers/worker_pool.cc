#include "server/workers/worker_pool.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>
#include <utility>

#include "server/routing/request_log.h"
#include "server/sandbox/spawn_process.h"
#include "storage/folder/sweep.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::seconds kYoung{5};  // a worker that lived shorter is not started again at once
constexpr std::chrono::seconds kBackoff{1};

}  // namespace

WorkerPool::WorkerPool(storage::DataDir dir, int count, bool draws_previews, storage::JobQueue& queue,
                       storage::UnitQueue& units, std::vector<std::string> words)
    : dir_(std::move(dir)),
      words_(std::move(words)),
      queue_(queue),
      units_(units),
      slots_(static_cast<std::size_t>(count)) {
  if (!draws_previews) return;
  slots_.emplace_back();
  slots_.back().draws_previews = true;
}

void WorkerPool::StartMissing() {
  if (is_stopping_) return;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (slots_[i].pid == 0 && Clock::now() >= slots_[i].not_before) Start(slots_[i], static_cast<int>(i));
  }
}

void WorkerPool::Start(Slot& slot, int index) {
  // One job a process: whatever memory a job took, the next one finds it given back.
  slot.name = fmt::format("{}{}-{}-{}", queue_.served_prefix(), getpid(), index, ++starts_);
  slot.started = Clock::now();
  std::vector<std::string> words = {"worker", "--data", dir_.root().string(), "--name", slot.name,
                                    "--jobs", "1"};
  words.insert(words.end(), words_.begin(), words_.end());
  if (slot.draws_previews) words.emplace_back("--previews");
  const Result<pid_t> started = SpawnSelf(std::move(words), Secrets::kKept);
  if (!started) {
    LogFailure("-", "worker", "could not be started: " + started.error().detail);
    slot.not_before = Clock::now() + kBackoff;
    return;
  }
  slot.pid = *started;
}

void WorkerPool::Interrupt() {
  for (const Slot& slot : slots_) {
    if (slot.pid != 0) kill(slot.pid, SIGTERM);
  }
}

void WorkerPool::Reap() {
  for (Slot& slot : slots_) {
    int status = 0;
    if (slot.pid != 0 && waitpid(slot.pid, &status, WNOHANG) == slot.pid) Ended(slot, status);
  }
}

void WorkerPool::Ended(Slot& slot, int status) {
  // A worker that this server killed to come to its own end has done no harm.
  const storage::WorkerEnd end = is_stopping_ ? storage::WorkerEnd::kInterrupted : storage::WorkerEnd::kDied;
  const Result<int> released = queue_.ReleaseWorker(slot.name, end, storage::Now());
  if (!released) LogFailure("-", "worker", released.error());
  const Result<int> units = units_.ReleaseWorker(slot.name, end, storage::Now());
  if (!units) LogFailure("-", "worker", units.error());
  const bool is_well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!is_stopping_ && !is_well) {
    LogFailure("-", "worker",
               fmt::format("{} (process {}) ended {}", slot.name, slot.pid, HowItEnded(status)));
    if (Clock::now() - slot.started < kYoung) slot.not_before = Clock::now() + kBackoff;
  }
  slot.pid = 0;
  // Also of a job that was cancelled while it waited for another attempt.
  const Result<storage::SweepReport> swept = storage::SweepWork(dir_, queue_, storage::Now());
  if (!swept) LogFailure("-", "worker", swept.error());
  if (swept) {
    for (const std::string& line : swept->moved) LogEvent(line);
  }
}

void WorkerPool::Stop(std::chrono::milliseconds grace) {
  is_stopping_ = true;
  Interrupt();
  const auto end = Clock::now() + grace;
  while (true) {
    Reap();
    bool has_left = false;
    for (const Slot& slot : slots_) has_left = has_left || slot.pid != 0;
    if (!has_left) return;
    if (Clock::now() >= end) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  for (Slot& slot : slots_) {
    if (slot.pid != 0) Ended(slot, WaitOrKill(slot.pid, std::chrono::milliseconds(0)).wait_status);
  }
}

}  // namespace skyquilt::server
