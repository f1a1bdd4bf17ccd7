#include "storage/catalogue/event_log.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kEventColumns = "SELECT seq, at_us, flight_id, job_id, kind, body FROM event WHERE ";

Event EventFrom(const Statement& row) {
  return RowOf<Event, std::int64_t, Time, std::string, std::optional<std::string>, std::string, std::string>(
      row);
}

}  // namespace

Result<std::vector<Event>> EventLog::After(std::int64_t seq, const EventFilter& filter, int limit) const {
  const auto db = db_.Read();
  const char* where = filter.job_id      ? "job_id=?2 AND CAST(?3 AS TEXT) IS NULL AND"
                      : filter.flight_id ? "flight_id=?3 AND CAST(?2 AS TEXT) IS NULL AND"
                                         : "CAST(?2 AS TEXT) IS NULL AND CAST(?3 AS TEXT) IS NULL AND";
  return db->All(EventFrom, std::string(kEventColumns) + where + " seq>?1 ORDER BY seq LIMIT ?4", seq,
                 filter.job_id, filter.job_id ? std::nullopt : filter.flight_id, limit);
}

Result<std::vector<Event>> EventLog::OfJob(const std::string& job_id) const {
  const auto db = db_.Read();
  return db->All(EventFrom, std::string(kEventColumns) + "job_id=? ORDER BY seq", job_id);
}

Result<std::int64_t> EventLog::Latest() const {
  const auto db = db_.Read();
  return db->Number("SELECT coalesce(max(seq),0) FROM event");
}

}  // namespace skyquilt::storage
