#include "storage/catalogue/webhooks.h"

#include <fmt/format.h>

#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::storage {
namespace {

Webhook WebhookFrom(const Statement& row) {
  return RowOf<Webhook, std::string, std::string, std::string, Time>(row);
}

}  // namespace

Result<Webhook> Webhooks::Add(const std::string& url, const std::string& secret, Time now) {
  const auto db = db_.Lock();
  Webhook webhook{NewId(), url, secret, now};
  SKYQUILT_TRY(db->Change("INSERT INTO webhook(id,url,secret,created_us) VALUES(?,?,?,?)", webhook.id, url,
                          secret, ToUs(now)));
  return webhook;
}

Result<std::vector<Webhook>> Webhooks::List() const {
  const auto db = db_.Read();
  return db->All(WebhookFrom, "SELECT id, url, secret, created_us FROM webhook ORDER BY id");
}

Result<void> Webhooks::Remove(const std::string& id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("DELETE FROM webhook WHERE id=?", id));
  if (db->Changes() == 0) return Error{ErrorCode::kNotFound, fmt::format("There is no webhook {}.", id), ""};
  return {};
}

Result<std::vector<Delivery>> Webhooks::Due(Time now, int limit) const {
  const auto db = db_.Read();
  return db->All(
      [](const Statement& row) {
        return Delivery{WebhookFrom(row), row.Get<std::int64_t>(4), row.Get<std::string>(5), row.Get<int>(6)};
      },
      "SELECT id, url, secret, created_us, event_seq, body, attempts FROM"
      " (SELECT w.id, w.url, w.secret, w.created_us, d.event_seq, d.body, d.attempts,"
      "  row_number() OVER (PARTITION BY w.id ORDER BY d.event_seq) AS nth FROM webhook_delivery d"
      "  JOIN webhook w ON w.id=d.webhook_id WHERE d.not_before_us<=?) AS due"
      " WHERE nth<=? ORDER BY event_seq",
      ToUs(now), limit);
}

Result<bool> Webhooks::Take(const Delivery& delivery, Time now) {
  if (!db_.IsShared()) return true;  // there is one server
  const auto db = db_.Lock();
  SKYQUILT_TRY(
      db->Change("UPDATE webhook_delivery SET not_before_us=?3 WHERE webhook_id=?1 AND event_seq=?2"
                 " AND not_before_us<=?4",
                 delivery.webhook.id, delivery.event_seq, ToUs(now + kDeliveryTurn), ToUs(now)));
  return db->Changes() > 0;
}

Result<void> Webhooks::Heard(const Delivery& delivery) {
  const auto db = db_.Lock();
  return db->Change("DELETE FROM webhook_delivery WHERE webhook_id=? AND event_seq=?", delivery.webhook.id,
                    delivery.event_seq);
}

Result<void> Webhooks::NotHeard(const Delivery& delivery, Time now) {
  if (delivery.attempts + 1 >= kMaxDeliveryAttempts) return Heard(delivery);
  const auto db = db_.Lock();
  return db->Change(
      "UPDATE webhook_delivery SET attempts=attempts+1, not_before_us=?3 WHERE webhook_id=?1 AND event_seq=?2",
      delivery.webhook.id, delivery.event_seq, ToUs(now + DeliveryPause(delivery.attempts)));
}

}  // namespace skyquilt::storage
