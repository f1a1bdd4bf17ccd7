// EventLog: the events of flights and jobs, in order, for clients that follow them or reconnect. Triggers of
// the database write it (storage/db/schema_sqlite.sql), so that no change can be missed; only the newest tens
// of thousands are kept. Any thread. Errors: kUnavailable, kIo.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct Event {
  std::int64_t seq = 0;  // grows by time, over all flights
  Time at;
  std::string flight_id;
  std::optional<std::string> job_id;
  std::string kind;  // "job", "map", "file", "preview" or "deleted"
  std::string body;  // JSON
};

struct EventFilter {
  std::optional<std::string> flight_id;
  std::optional<std::string> job_id;
};

class EventLog {
 public:
  explicit EventLog(CatalogueDb& db) : db_(db) {}
  // The events behind `seq`, oldest first.
  Result<std::vector<Event>> After(std::int64_t seq, const EventFilter& filter, int limit) const;
  // All of one job, oldest first; how many that may be, the log itself bounds.
  Result<std::vector<Event>> OfJob(const std::string& job_id) const;
  Result<std::int64_t> Latest() const;

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
