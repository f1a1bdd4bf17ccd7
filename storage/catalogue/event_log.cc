#include "storage/catalogue/event_log.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::vector<Event>> EventLog::After(std::int64_t seq, const EventFilter& filter, int limit) const {
  const auto db = db_.Read();
  const char* where = filter.job_id      ? "job_id=?2 AND CAST(?3 AS TEXT) IS NULL AND"
                      : filter.flight_id ? "flight_id=?3 AND CAST(?2 AS TEXT) IS NULL AND"
                                         : "CAST(?2 AS TEXT) IS NULL AND CAST(?3 AS TEXT) IS NULL AND";
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(std::string("SELECT seq, at_us, flight_id, job_id, kind, body FROM event WHERE ") + where +
                  " seq>?1 ORDER BY seq LIMIT ?4"));
  query.Bind(1, seq).BindNull(2).BindNull(3).Bind(4, limit);
  if (filter.job_id) {
    query.Bind(2, *filter.job_id);
  } else if (filter.flight_id) {
    query.Bind(3, *filter.flight_id);
  }
  std::vector<Event> events;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return events;
    Event event;
    event.seq = query.ColumnInt64(0);
    event.at = FromUs(query.ColumnInt64(1));
    event.flight_id = query.ColumnText(2);
    if (!query.IsNull(3)) event.job_id = std::string(query.ColumnText(3));
    event.kind = query.ColumnText(4);
    event.body = query.ColumnText(5);
    events.push_back(std::move(event));
  }
}

Result<std::int64_t> EventLog::Latest() const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(Statement query, db->Prepare("SELECT coalesce(max(seq),0) FROM event"));
  SKYQUILT_TRY(query.Step());
  return query.ColumnInt64(0);
}

}  // namespace skyquilt::storage
