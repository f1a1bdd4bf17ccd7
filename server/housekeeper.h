// Housekeeper: the periodic work of a running server, every few minutes: saves the AgeClock and removes what
// has expired. A thread of its own; failures are logged and retried in the next round. Owned by the main
// thread.
#pragma once

#include <chrono>
#include <optional>

#include "api/service.h"
#include "server/background_thread.h"

namespace skyquilt::server {

class Housekeeper {
 public:
  explicit Housekeeper(api::Service& service);

 private:
  void Round();
  void TrashIdle();

  api::Service& service_;
  std::optional<std::chrono::steady_clock::time_point> swept_;        // blobs, as a whole
  std::optional<std::chrono::steady_clock::time_point> looked_idle_;  // at flights that nobody changes
  BackgroundThread thread_;
};

}  // namespace skyquilt::server
