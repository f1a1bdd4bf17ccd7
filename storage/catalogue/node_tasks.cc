#include "storage/catalogue/node_tasks.h"

#include <fmt/format.h>

#include "core/base/try.h"
#include "storage/catalogue/webhooks.h"

namespace skyquilt::storage {
namespace {

Error NoSuchTask(const std::string& uuid) {
  return {ErrorCode::kNotFound, fmt::format("There is no task {}.", uuid), ""};
}

}  // namespace

Result<void> NodeTasks::Add(const NodeTask& task) {
  const auto db = db_.Lock();
  // Its client knows nothing of a trash: the name of a task that it removed is free. The flight there is
  // kept.
  SKYQUILT_TRY(db->Change(
      "DELETE FROM node_task WHERE uuid=? AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NOT NULL)",
      task.uuid));
  return db->Change(
      "INSERT INTO node_task(uuid,flight_id,options,created_ms,is_committed,notes,webhook,outputs)"
      " VALUES(?,?,?,?,?,?,?,?)",
      task.uuid, task.flight_id, task.options, task.created_ms, task.is_committed ? 1 : 0, task.notes,
      task.webhook, task.outputs);
}

Result<NodeTask> NodeTasks::Find(const std::string& uuid) const {
  const auto db = db_.Read();
  const auto task_from = [](const Statement& row) {
    NodeTask task;
    row.Into(task.uuid, task.flight_id, task.options, task.created_ms, task.is_committed, task.notes,
             task.canceled_job, task.webhook, task.outputs);
    return task;
  };
  return db->One(task_from, NoSuchTask(uuid),
                 "SELECT uuid, flight_id, options, created_ms, is_committed, notes, canceled_job, webhook,"
                 " outputs FROM node_task WHERE uuid=?"
                 " AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL)",
                 uuid);
}

Result<std::vector<std::string>> NodeTasks::List() const {
  const auto db = db_.Read();
  return db->AllText(
      "SELECT uuid FROM node_task WHERE is_committed=1"
      " AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL) ORDER BY flight_id");
}

Result<void> NodeTasks::Commit(const std::string& uuid) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change("UPDATE node_task SET is_committed=1 WHERE uuid=?", uuid));
  if (db->Changes() == 0) return NoSuchTask(uuid);
  return {};
}

Result<void> NodeTasks::AddNote(const std::string& uuid, const std::string& line) {
  const auto db = db_.Lock();
  return db->Change(
      "UPDATE node_task SET notes=notes||?2 WHERE uuid=?1 AND replace(notes,?2,'')=notes AND length(notes)<65536",
      uuid, line + "\n");
}

Result<void> NodeTasks::MarkCanceled(const std::string& uuid, const std::string& job_id) {
  const auto db = db_.Lock();
  return db->Change("UPDATE node_task SET canceled_job=?2 WHERE uuid=?1", uuid, job_id);
}

Result<void> NodeTasks::Restart(const std::string& uuid, const std::string& options,
                                std::int64_t created_ms) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(
      db->Change("UPDATE node_task SET options=?2, created_ms=?3 WHERE uuid=?1", uuid, options, created_ms));
  if (db->Changes() == 0) return NoSuchTask(uuid);
  return {};
}

Result<std::vector<NodeDelivery>> NodeDeliveries::Due(Time now, int limit) const {
  const auto db = db_.Read();
  return db->All(RowOf<NodeDelivery, std::string, std::string, std::string, int>,
                 "SELECT uuid, job_id, webhook, attempts FROM"
                 " (SELECT d.uuid, d.job_id, t.webhook, d.attempts, d.not_before_us, row_number()"
                 "  OVER (PARTITION BY t.webhook ORDER BY d.not_before_us, d.job_id) AS nth"
                 "  FROM node_delivery d JOIN node_task t ON t.uuid=d.uuid WHERE d.not_before_us<=?) AS due"
                 " WHERE nth<=? ORDER BY not_before_us, job_id",
                 ToUs(now), limit);
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
