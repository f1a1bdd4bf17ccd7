#include "api/events/event_hub.h"

namespace skyquilt::api {

Result<std::shared_ptr<const EventHub::Now>> EventHub::Look() {
  constexpr std::chrono::milliseconds kFreshFor{250};
  const auto at = std::chrono::steady_clock::now();
  const std::lock_guard lock(mutex_);
  if (now_ != nullptr && at - looked_at_ < kFreshFor) return now_;
  const Result<std::int64_t> latest = events_.Latest();
  if (!latest) return latest.error();
  Result<std::vector<storage::Job>> running = queue_.ListRunning();
  if (!running) return running.error();
  now_ = std::make_shared<const Now>(Now{*latest, *std::move(running)});
  looked_at_ = at;
  return now_;
}

}  // namespace skyquilt::api
