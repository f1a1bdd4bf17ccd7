// SessionSet: the open connections, to limit their number in total and per client, and so that a server that
// is shutting down can close idle ones and wait for the rest. Any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace skyquilt::server {

class SessionSet {
 public:
  // A place among those that may be open, given back when the last copy goes. Null: there is none.
  using Place = std::shared_ptr<const std::string>;
  // `client` empty: it has no bound of its own. `max_of_client` 0: nobody has.
  Place Admit(const std::string& client, std::size_t most, std::size_t max_of_client);

  // `close_if_idle` is called from any thread and must not block. Answers the key for Remove.
  std::uint64_t Add(std::function<void()> close_if_idle);
  void Remove(std::uint64_t key);
  void CloseIdle();
  // True when the last one has gone.
  bool WaitForNone(std::chrono::milliseconds timeout);

 private:
  void GiveBack(const std::string& client);

  std::mutex mutex_;
  std::size_t admitted_ = 0;
  std::map<std::string, std::size_t> of_client_;
  std::condition_variable none_;
  std::map<std::uint64_t, std::function<void()>> sessions_;
  std::uint64_t next_ = 0;
};

}  // namespace skyquilt::server
