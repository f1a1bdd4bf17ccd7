#include "server/webhooks/webhook_sender.h"

#include <fmt/format.h>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "api/nodeodm/nodeodm.h"
#include "api/webhooks/webhooks.h"
#include "core/base/parallel_for.h"
#include "server/routing/request_log.h"
#include "server/webhooks/post_message.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kDeliveryPause{500};
constexpr std::chrono::seconds kLookForRetries{2};  // those wait for their time
constexpr int kAtOnce = 20;                         // messages to one receiver
constexpr int kReceiversAtOnce = 16;

bool MayTell(const Result<bool>& taken) {
  if (!taken) LogFailure("-", "webhook", taken.error());
  return taken && *taken;
}

}  // namespace

WebhookSender::WebhookSender(api::Service& service, bool may_go_private)
    : service_(service),
      webhooks_(service.db),
      node_deliveries_(service.db),
      may_go_private_(may_go_private),
      thread_([this] { Run(); }) {}

void WebhookSender::Run() {
  std::chrono::steady_clock::time_point looked;
  for (; !thread_.IsEnded(); thread_.Rest(kDeliveryPause)) {
    const auto now = std::chrono::steady_clock::now();
    if (!service_.db.WasWritten() && now - looked < kLookForRetries) continue;
    TellAllDue();
    looked = now;
  }
}

// Receivers are told side by side, each in order, until one does not hear: what else it is to hear waits for
// the next round.
void WebhookSender::TellAllDue() {
  const storage::Time now = service_.db.ages().Now();
  const auto due = webhooks_.Due(now, kAtOnce);
  if (!due) return LogFailure("-", "webhook", due.error());
  const auto of_tasks = node_deliveries_.Due(now, kAtOnce);
  if (!of_tasks) return LogFailure("-", "webhook", of_tasks.error());
  std::map<std::string, std::vector<std::function<bool()>>> tells;  // by receiver; whether it heard
  for (const storage::Delivery& delivery : *due) {
    tells[delivery.webhook.url].emplace_back([this, &delivery] {
      return !MayTell(webhooks_.Take(delivery, service_.db.ages().Now())) || Tell(delivery);
    });
  }
  for (const storage::NodeDelivery& delivery : *of_tasks) {
    tells[delivery.url].emplace_back([this, &delivery] {
      return !MayTell(node_deliveries_.Take(delivery, service_.db.ages().Now())) || Tell(delivery);
    });
  }
  std::vector<const std::vector<std::function<bool()>>*> receivers;
  for (const auto& [url, of_receiver] : tells) receivers.push_back(&of_receiver);
  ParallelFor(receivers.size(), kReceiversAtOnce, [&](std::size_t i) {
    for (const std::function<bool()>& tell : *receivers[i]) {
      if (thread_.IsEnded() || !tell()) return;
    }
  });
}

bool WebhookSender::Tell(const storage::Delivery& delivery) {
  const std::int64_t at_s = storage::ToUs(storage::Now()) / 1'000'000;
  const OutgoingMessage message{
      delivery.webhook.url,
      {{"Content-Type", "application/json"},
       {"User-Agent", "Skyquilt"},
       {"X-Skyquilt-Delivery", fmt::format("{}-{}", delivery.webhook.id, delivery.event_seq)},
       {"X-Skyquilt-Signature", api::WebhookSignature(delivery.webhook.secret, at_s, delivery.body)}},
      delivery.body,
      may_go_private_};
  const Result<void> posted = PostMessage(message);
  if (!posted) LogFailure(delivery.webhook.id, "webhook", posted.error());
  const Result<void> kept =
      posted ? webhooks_.Heard(delivery) : webhooks_.NotHeard(delivery, service_.db.ages().Now());
  if (!kept) LogFailure(delivery.webhook.id, "webhook", kept.error());
  return posted.ok();
}

bool WebhookSender::Tell(const storage::NodeDelivery& delivery) {
  const Result<std::string> body = api::NodeWebhookBody(service_, delivery.uuid, delivery.job_id);
  const bool is_gone = !body && body.error().code == ErrorCode::kNotFound;
  Result<void> told;
  if (body) {
    told = PostMessage({delivery.url,
                        {{"Content-Type", "application/json"},
                         {"User-Agent", "Skyquilt"},
                         {"X-Skyquilt-Delivery", delivery.uuid + "-" + delivery.job_id}},
                        *body,
                        may_go_private_});
  } else if (!is_gone) {
    told = body.error();
  }
  if (!told) LogFailure(delivery.uuid, "webhook", told.error());
  const Result<void> kept =
      told ? node_deliveries_.Heard(delivery) : node_deliveries_.NotHeard(delivery, service_.db.ages().Now());
  if (!kept) LogFailure(delivery.uuid, "webhook", kept.error());
  return told.ok();
}

}  // namespace skyquilt::server
