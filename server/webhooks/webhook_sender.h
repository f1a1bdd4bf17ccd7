// WebhookSender: delivers signed webhook messages and retries until they are received. A thread of its own,
// for as long as it lives.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "storage/catalogue/webhooks.h"

namespace skyquilt::server {

class WebhookSender {
 public:
  // `ages`: by which it waits before it tells again.
  WebhookSender(storage::Webhooks& webhooks, const storage::AgeClock& ages, bool may_go_private);
  ~WebhookSender();  // waits for a delivery under way

 private:
  void Run();
  void Tell(const storage::Delivery& delivery);

  storage::Webhooks& webhooks_;
  const storage::AgeClock& ages_;
  const bool may_go_private_;
  std::mutex mutex_;
  std::condition_variable end_;
  bool is_ended_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace skyquilt::server
