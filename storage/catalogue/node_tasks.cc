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
  SKYQUILT_TRY_ASSIGN(
      Statement let_go,
      db->Prepare(
          "DELETE FROM node_task WHERE uuid=? AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NOT NULL)"));
  SKYQUILT_TRY(let_go.Bind(1, task.uuid).Run());
  SKYQUILT_TRY_ASSIGN(
      Statement insert,
      db->Prepare(
          "INSERT INTO node_task(uuid,flight_id,options,created_ms,is_committed,notes,webhook,outputs)"
          " VALUES(?,?,?,?,?,?,?,?)"));
  return insert.Bind(1, task.uuid)
      .Bind(2, task.flight_id)
      .Bind(3, task.options)
      .Bind(4, task.created_ms)
      .Bind(5, task.is_committed ? 1 : 0)
      .Bind(6, task.notes)
      .Bind(7, task.webhook)
      .Bind(8, task.outputs)
      .Run();
}

Result<NodeTask> NodeTasks::Find(const std::string& uuid) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(
          "SELECT uuid, flight_id, options, created_ms, is_committed, notes, canceled_job, webhook, outputs FROM node_task WHERE uuid=?"
          " AND flight_id IN (SELECT id FROM flight WHERE deleted_us IS NULL)"));
  SKYQUILT_TRY_ASSIGN(const bool row, query.Bind(1, uuid).Step());
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
  std::vector<std::string> uuids;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return uuids;
    uuids.emplace_back(query.ColumnText(0));
  }
}

Result<void> NodeTasks::Commit(const std::string& uuid) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement update, db->Prepare("UPDATE node_task SET is_committed=1 WHERE uuid=?"));
  SKYQUILT_TRY(update.Bind(1, uuid).Run());
  if (db->Changes() == 0) return NoSuchTask(uuid);
  return {};
}

Result<void> NodeTasks::AddNote(const std::string& uuid, const std::string& line) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      Statement update,
      db->Prepare(
          "UPDATE node_task SET notes=notes||?2 WHERE uuid=?1 AND replace(notes,?2,'')=notes AND length(notes)<65536"));
  return update.Bind(1, uuid).Bind(2, line + "\n").Run();
}

Result<void> NodeTasks::MarkCanceled(const std::string& uuid, const std::string& job_id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement update, db->Prepare("UPDATE node_task SET canceled_job=?2 WHERE uuid=?1"));
  return update.Bind(1, uuid).Bind(2, job_id).Run();
}

Result<void> NodeTasks::Restart(const std::string& uuid, const std::string& options,
                                std::int64_t created_ms) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement update,
                      db->Prepare("UPDATE node_task SET options=?2, created_ms=?3 WHERE uuid=?1"));
  SKYQUILT_TRY(update.Bind(1, uuid).Bind(2, options).Bind(3, created_ms).Run());
  if (db->Changes() == 0) return NoSuchTask(uuid);
  return {};
}

}  // namespace skyquilt::storage
