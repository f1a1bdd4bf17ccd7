#include "server/http/session_set.h"

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

SessionSet::Place SessionSet::Admit(const std::string& client, std::size_t most, std::size_t max_of_client) {
  const std::lock_guard lock(mutex_);
  if (admitted_ >= most) return nullptr;
  if (!client.empty()) {
    std::size_t& held = of_client_[client];
    if (max_of_client > 0 && held >= max_of_client) return nullptr;
    ++held;
  }
  ++admitted_;
  return {new std::string(client), [this](const std::string* name) {
            GiveBack(*name);
            delete name;
          }};
}

void SessionSet::GiveBack(const std::string& client) {
  const std::lock_guard lock(mutex_);
  --admitted_;
  const auto held = of_client_.find(client);
  if (held != of_client_.end() && --held->second == 0) of_client_.erase(held);
}

bool SessionSet::WaitForNone(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return none_.wait_for(lock, timeout, [&] { return sessions_.empty(); });
}

}  // namespace skyquilt::server
