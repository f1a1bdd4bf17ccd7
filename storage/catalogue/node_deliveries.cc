#include "storage/catalogue/node_deliveries.h"

#include "core/base/try.h"
#include "storage/catalogue/webhooks.h"

namespace skyquilt::storage {

Result<std::vector<NodeDelivery>> NodeDeliveries::Due(Time now, int limit) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Query("SELECT d.uuid, d.job_id, t.webhook, d.attempts FROM node_delivery d"
                                " JOIN node_task t ON t.uuid=d.uuid WHERE d.not_before_us<=?"
                                " ORDER BY d.not_before_us LIMIT ?",
                                ToUs(now), limit));
  return query.All([](const Statement& row) {
    return NodeDelivery{std::string(row.ColumnText(0)), std::string(row.ColumnText(1)),
                        std::string(row.ColumnText(2)), static_cast<int>(row.ColumnInt64(3))};
  });
}

Result<bool> NodeDeliveries::Take(const NodeDelivery& delivery, Time now) {
  if (!db_.IsShared()) return true;  // there is one server
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change(
      "UPDATE node_delivery SET not_before_us=?3 WHERE uuid=?1 AND job_id=?2 AND not_before_us<=?4",
      delivery.uuid, delivery.job_id, ToUs(now + kDeliveryTurn), ToUs(now)));
  return db->Changes() > 0;
}

Result<void> NodeDeliveries::Heard(const NodeDelivery& delivery) {
  const auto db = db_.Lock();
  return db->Change("DELETE FROM node_delivery WHERE uuid=? AND job_id=?", delivery.uuid, delivery.job_id);
}

Result<void> NodeDeliveries::NotHeard(const NodeDelivery& delivery, Time now) {
  if (delivery.attempts + 1 >= kMaxDeliveryAttempts) return Heard(delivery);
  const auto db = db_.Lock();
  return db->Change(
      "UPDATE node_delivery SET attempts=attempts+1, not_before_us=?3 WHERE uuid=?1 AND job_id=?2",
      delivery.uuid, delivery.job_id, ToUs(now + DeliveryPause(delivery.attempts)));
}

}  // namespace skyquilt::storage
