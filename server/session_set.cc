#include "server/session_set.h"

#include <utility>

namespace skyquilt::server {

std::uint64_t SessionSet::Add(std::function<void()> close_if_idle) {
  const std::lock_guard lock(mutex_);
  sessions_.emplace(next_, std::move(close_if_idle));
  return next_++;
}

void SessionSet::Remove(std::uint64_t key) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(key);
  if (sessions_.empty()) none_.notify_all();
}

void SessionSet::CloseIdle() {
  const std::lock_guard lock(mutex_);
  for (const auto& [key, close_if_idle] : sessions_) close_if_idle();
}

std::size_t SessionSet::count() const {
  const std::lock_guard lock(mutex_);
  return sessions_.size();
}

bool SessionSet::WaitForNone(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return none_.wait_for(lock, timeout, [&] { return sessions_.empty(); });
}

}  // namespace skyquilt::server
