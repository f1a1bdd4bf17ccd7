#include "storage/catalogue/webhooks.h"

#include <fmt/format.h>

#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::storage {
Result<Webhook> Webhooks::Add(const std::string& url, const std::string& secret, Time now) {
  const auto db = db_.Lock();
  Webhook webhook{NewId(), url, secret, now};
  SKYQUILT_TRY_ASSIGN(Statement insert,
                      db->Prepare("INSERT INTO webhook(id,url,secret,created_us) VALUES(?,?,?,?)"));
  SKYQUILT_TRY(insert.Bind(1, webhook.id).Bind(2, url).Bind(3, secret).Bind(4, ToUs(now)).Run());
  return webhook;
}

Result<std::vector<Webhook>> Webhooks::List() const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Prepare("SELECT id, url, secret, created_us FROM webhook ORDER BY id"));
  std::vector<Webhook> webhooks;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return webhooks;
    webhooks.push_back({std::string(query.ColumnText(0)), std::string(query.ColumnText(1)),
                        std::string(query.ColumnText(2)), FromUs(query.ColumnInt64(3))});
  }
}

Result<void> Webhooks::Remove(const std::string& id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement remove, db->Prepare("DELETE FROM webhook WHERE id=?"));
  SKYQUILT_TRY(remove.Bind(1, id).Run());
  if (db->Changes() == 0) return Error{ErrorCode::kNotFound, fmt::format("There is no webhook {}.", id), ""};
  return {};
}

Result<std::vector<Delivery>> Webhooks::Due(Time now, int limit) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(
          "SELECT w.id, w.url, w.secret, w.created_us, d.event_seq, d.body, d.attempts FROM webhook_delivery d"
          " JOIN webhook w ON w.id=d.webhook_id WHERE d.not_before_us<=? ORDER BY d.event_seq LIMIT ?"));
  query.Bind(1, ToUs(now)).Bind(2, limit);
  std::vector<Delivery> due;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return due;
    due.push_back({{std::string(query.ColumnText(0)), std::string(query.ColumnText(1)),
                    std::string(query.ColumnText(2)), FromUs(query.ColumnInt64(3))},
                   query.ColumnInt64(4),
                   std::string(query.ColumnText(5)),
                   static_cast<int>(query.ColumnInt64(6))});
  }
}

Result<bool> Webhooks::Take(const Delivery& delivery, Time now) {
  if (!db_.IsShared()) return true;  // there is one server
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare("UPDATE webhook_delivery SET not_before_us=?3 WHERE webhook_id=?1 AND event_seq=?2"
                  " AND not_before_us<=?4"));
  update.Bind(1, delivery.webhook.id).Bind(2, delivery.event_seq).Bind(3, ToUs(now + kDeliveryTurn));
  SKYQUILT_TRY(update.Bind(4, ToUs(now)).Run());
  return db->Changes() > 0;
}

Result<void> Webhooks::Heard(const Delivery& delivery) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement remove,
                      db->Prepare("DELETE FROM webhook_delivery WHERE webhook_id=? AND event_seq=?"));
  return remove.Bind(1, delivery.webhook.id).Bind(2, delivery.event_seq).Run();
}

Result<void> Webhooks::NotHeard(const Delivery& delivery, Time now) {
  if (delivery.attempts + 1 >= kMaxDeliveryAttempts) return Heard(delivery);
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare("UPDATE webhook_delivery SET attempts=attempts+1, not_before_us=?3 WHERE webhook_id=?1 AND "
                  "event_seq=?2"));
  const Time again = now + DeliveryPause(delivery.attempts);
  return update.Bind(1, delivery.webhook.id).Bind(2, delivery.event_seq).Bind(3, ToUs(again)).Run();
}

}  // namespace skyquilt::storage
