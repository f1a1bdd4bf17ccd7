// Housekeeper: the periodic work of a running server, every few minutes: saves the AgeClock and removes what
// has expired. A thread of its own; failures are logged and retried in the next round. Owned by the main
// thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "api/service.h"

namespace skyquilt::server {

class Housekeeper {
 public:
  explicit Housekeeper(api::Service& service);
  ~Housekeeper();
  Housekeeper(const Housekeeper&) = delete;
  Housekeeper& operator=(const Housekeeper&) = delete;

 private:
  void Run();
  void Round();
  void TrashIdle();

  api::Service& service_;
  std::mutex mutex_;
  std::condition_variable end_;
  bool is_ended_ = false;
  std::optional<std::chrono::steady_clock::time_point> swept_;        // blobs, as a whole
  std::optional<std::chrono::steady_clock::time_point> looked_idle_;  // at flights that nobody changes
  std::thread thread_;
};

}  // namespace skyquilt::server
