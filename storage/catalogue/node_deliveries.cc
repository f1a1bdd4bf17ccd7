#include "storage/catalogue/node_deliveries.h"

#include "core/base/try.h"
#include "storage/catalogue/webhooks.h"

namespace skyquilt::storage {

Result<std::vector<NodeDelivery>> NodeDeliveries::Due(Time now, int limit) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Prepare("SELECT d.uuid, d.job_id, t.webhook, d.attempts FROM node_delivery d"
                                  " JOIN node_task t ON t.uuid=d.uuid WHERE d.not_before_us<=?"
                                  " ORDER BY d.not_before_us LIMIT ?"));
  query.Bind(1, ToUs(now)).Bind(2, limit);
  std::vector<NodeDelivery> due;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return due;
    due.push_back({std::string(query.ColumnText(0)), std::string(query.ColumnText(1)),
                   std::string(query.ColumnText(2)), static_cast<int>(query.ColumnInt64(3))});
  }
}

Result<bool> NodeDeliveries::Take(const NodeDelivery& delivery, Time now) {
  if (!db_.IsShared()) return true;  // there is one server
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db->Prepare("UPDATE node_delivery SET not_before_us=?3 WHERE uuid=?1 AND job_id=?2"
                                  " AND not_before_us<=?4"));
  update.Bind(1, delivery.uuid).Bind(2, delivery.job_id).Bind(3, ToUs(now + kDeliveryTurn));
  SKYQUILT_TRY(update.Bind(4, ToUs(now)).Run());
  return db->Changes() > 0;
}

Result<void> NodeDeliveries::Heard(const NodeDelivery& delivery) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement remove, db->Prepare("DELETE FROM node_delivery WHERE uuid=? AND job_id=?"));
  return remove.Bind(1, delivery.uuid).Bind(2, delivery.job_id).Run();
}

Result<void> NodeDeliveries::NotHeard(const NodeDelivery& delivery, Time now) {
  if (delivery.attempts + 1 >= kMaxDeliveryAttempts) return Heard(delivery);
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE node_delivery SET attempts=attempts+1, not_before_us=?3 WHERE uuid=?1 AND job_id=?2"));
  const Time again = now + DeliveryPause(delivery.attempts);
  return update.Bind(1, delivery.uuid).Bind(2, delivery.job_id).Bind(3, ToUs(again)).Run();
}

}  // namespace skyquilt::storage
