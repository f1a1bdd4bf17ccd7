// WebhookSender: delivers signed webhook messages, and what clients of the NodeODM-compatible node want to
// hear of their tasks, and retries until they are received; receivers that do not answer hold up others for
// one message's time, not for that of all of theirs. A thread of its own, for as long as it lives.
#pragma once

#include "api/service.h"
#include "server/background_thread.h"
#include "storage/catalogue/node_tasks.h"
#include "storage/catalogue/webhooks.h"

namespace skyquilt::server {

class WebhookSender {
 public:
  // At its end it waits for a delivery under way.
  WebhookSender(api::Service& service, bool may_go_private);

 private:
  void Run();
  void TellAllDue();
  // Whether it was heard.
  bool Tell(const storage::Delivery& delivery);
  bool Tell(const storage::NodeDelivery& delivery);

  api::Service& service_;
  storage::Webhooks webhooks_;
  storage::NodeDeliveries node_deliveries_;
  const bool may_go_private_;
  BackgroundThread thread_;
};

}  // namespace skyquilt::server
