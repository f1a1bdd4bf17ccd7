// SessionSet: the connections that are open, so that a server which is shutting down can close the idle ones
// and wait for the rest. Any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>

namespace skyquilt::server {

class SessionSet {
 public:
  // `close_if_idle` is called from any thread and must not block. Answers the key for Remove.
  std::uint64_t Add(std::function<void()> close_if_idle);
  void Remove(std::uint64_t key);
  void CloseIdle();
  std::size_t count() const;
  // True when the last one has gone.
  bool WaitForNone(std::chrono::milliseconds timeout);

 private:
  mutable std::mutex mutex_;
  std::condition_variable none_;
  std::map<std::uint64_t, std::function<void()>> sessions_;
  std::uint64_t next_ = 0;
};

}  // namespace skyquilt::server
