// NodeTasks: which flight belongs to which task of the NodeODM-compatible node. A task is deleted with its
// flight. NodeDeliveries: ends of tasks that are still to be told. Any thread, any number of processes.
// Errors: kNotFound (no such task), kConflict (the UUID is taken), kOutOfSpace, kUnavailable, kIo.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct NodeTask {
  std::string uuid;
  std::string flight_id;
  std::string options;  // JSON list of {name, value}
  std::int64_t created_ms = 0;
  bool is_committed = false;
  std::string notes = {};         // what the client should know, each line ended by a line feed
  std::string canceled_job = {};  // the job that its client cancelled, ended or not
  std::string webhook = {};       // address that is told of its end; empty: nobody
  std::string outputs = "[]";     // JSON list of the paths that all.zip shall hold; empty: the usual ones
};

class NodeTasks {
 public:
  explicit NodeTasks(CatalogueDb& db) : db_(db) {}
  Result<void> Add(const NodeTask& task);
  Result<NodeTask> Find(const std::string& uuid) const;
  // The committed ones, oldest first.
  Result<std::vector<std::string>> List() const;
  Result<void> Commit(const std::string& uuid);
  // A line that is there already, or beyond 64 KiB of them, is not added.
  Result<void> AddNote(const std::string& uuid, const std::string& line);
  Result<void> MarkCanceled(const std::string& uuid, const std::string& job_id);
  // The task begins anew.
  Result<void> Restart(const std::string& uuid, const std::string& options, std::int64_t created_ms);

 private:
  CatalogueDb& db_;
};

// The end of a task, to be told to the address that came with it. A trigger of the database writes these
// (storage/db/schema_sqlite.sql); one process delivers.
struct NodeDelivery {
  std::string uuid;  // of the task
  std::string job_id;
  std::string url;
  int attempts = 0;  // that failed
};

class NodeDeliveries {
 public:
  explicit NodeDeliveries(CatalogueDb& db) : db_(db) {}

  // Of each address up to `limit`.
  Result<std::vector<NodeDelivery>> Due(Time now, int limit) const;
  // Before it is told. False: another server of the same catalogue has taken it, or it was heard.
  Result<bool> Take(const NodeDelivery& delivery, Time now);
  // Also of one of which nobody needs to hear any more.
  Result<void> Heard(const NodeDelivery& delivery);
  // Tried again later, as other webhooks are.
  Result<void> NotHeard(const NodeDelivery& delivery, Time now);

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
