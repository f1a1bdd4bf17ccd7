#include "server/webhooks/webhook_sender.h"

#include <fmt/format.h>

#include "api/webhooks/webhooks.h"
#include "server/routing/request_log.h"
#include "server/webhooks/post_message.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kDeliveryPause{500};
constexpr int kAtOnce = 20;

}  // namespace

WebhookSender::WebhookSender(storage::Webhooks& webhooks, const storage::AgeClock& ages, bool may_go_private)
    : webhooks_(webhooks), ages_(ages), may_go_private_(may_go_private), thread_([this] { Run(); }) {}

WebhookSender::~WebhookSender() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  end_.notify_all();
  thread_.join();
}

void WebhookSender::Run() {
  std::unique_lock lock(mutex_);
  while (!is_ended_) {
    lock.unlock();
    const Result<std::vector<storage::Delivery>> due = webhooks_.Due(ages_.Now(), kAtOnce);
    if (!due) LogFailure("-", "webhook", due.error().detail);
    if (due) {
      for (const storage::Delivery& delivery : *due) {
        Tell(delivery);
        const std::lock_guard look(mutex_);
        if (is_ended_) return;
      }
    }
    lock.lock();
    end_.wait_for(lock, kDeliveryPause, [this] { return is_ended_; });
  }
}

void WebhookSender::Tell(const storage::Delivery& delivery) {
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
  if (!posted)
    LogFailure(delivery.webhook.id, "webhook", posted.error().message + " " + posted.error().detail);
  const Result<void> kept = posted ? webhooks_.Heard(delivery) : webhooks_.NotHeard(delivery, ages_.Now());
  if (!kept) LogFailure(delivery.webhook.id, "webhook", kept.error().detail);
}

}  // namespace skyquilt::server
