// WebhookSender: delivers signed webhook messages, and what clients of the NodeODM-compatible node want to
// hear of their tasks, and retries until they are received. A thread of its own, for as long as it lives.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "api/service.h"

namespace skyquilt::server {

class WebhookSender {
 public:
  WebhookSender(api::Service& service, bool may_go_private);
  ~WebhookSender();  // waits for a delivery under way

 private:
  void Run();
  void TellAllDue();
  bool IsEnded();
  void Tell(const storage::Delivery& delivery);
  void Tell(const storage::NodeDelivery& delivery);

  api::Service& service_;
  const bool may_go_private_;
  std::mutex mutex_;
  std::condition_variable end_;
  bool is_ended_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace skyquilt::server
