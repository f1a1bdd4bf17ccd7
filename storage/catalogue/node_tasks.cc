#include "storage/catalogue/node_tasks.h"

#include <fmt/format.h>

#include "core/base/try.h"

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
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query(
          "SELECT uuid, flight_id, options, created_ms, is_committed, notes, canceled_job, webhook, outputs FROM node_task WHERE uuid=?"
          " AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL)",
          uuid));
  SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
  if (!row) return NoSuchTask(uuid);
  NodeTask task;
  task.uuid = query.ColumnText(0);
  task.flight_id = query.ColumnText(1);
  task.options = query.ColumnText(2);
  task.created_ms = query.ColumnInt64(3);
  task.is_committed = query.ColumnInt64(4) != 0;
  task.notes = query.ColumnText(5);
  task.canceled_job = query.ColumnText(6);
  task.webhook = query.ColumnText(7);
  task.outputs = query.ColumnText(8);
  return task;
}

Result<std::vector<std::string>> NodeTasks::List() const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare("SELECT uuid FROM node_task WHERE is_committed=1"
                  " AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL) ORDER BY flight_id"));
  return query.AllText();
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

}  // namespace skyquilt::storage
