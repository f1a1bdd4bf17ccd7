#include "storage/catalogue/trash.h"

#include <fmt/format.h>

#include "core/base/try.h"
#include "storage/catalogue/cancel_jobs.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kTrashColumns =
    "SELECT id, name, created_us, (SELECT count(*) FROM file WHERE flight_id=f.id),"
    " (SELECT coalesce(sum(bytes),0) FROM file WHERE flight_id=f.id), deleted_us, deleted_age_us, owner FROM flight f"
    " WHERE deleted_us IS NOT NULL ";

TrashedFlight TrashedFlightFrom(const Statement& row) {
  TrashedFlight flight;
  row.Into(flight.id, flight.name, flight.created, flight.file_count, flight.bytes, flight.deleted,
           flight.deleted_age, flight.owner);
  return flight;
}

Error NotInTrash(const std::string& id) {
  return {ErrorCode::kNotFound,
          fmt::format("There is no deleted flight {}. It may have been restored, or removed for good.", id),
          ""};
}

}  // namespace

// A record that cannot take it (the disk is full, and deleting is what mends that) must not keep the flight
// where it is: a repair then brings the flight back out of the trash, or into it, and loses nothing.
void Trash::Record(const std::string& flight_id, std::optional<Time> trashed) const {
  if (records_) (void)records_->SetTrashed(flight_id, trashed).ok();
}

Result<void> Trash::Put(const std::string& flight_id, Time now) {
  SKYQUILT_TRY(PutIf(flight_id, now, [](SqlConnection&) { return true; }));
  return {};
}

Result<bool> Trash::PutIf(const std::string& flight_id, Time now, const Condition& is_wanted) {
  return db_.Again([&]() -> Result<bool> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight_id));
    SKYQUILT_TRY_ASSIGN(const bool wanted, is_wanted(*db));
    if (!wanted) return false;
    const std::int64_t age = ToUs(db_.ages().Now());
    SKYQUILT_TRY(db->Change(std::string(kCancelJobs) + "flight_id=?1", flight_id, ToUs(now)));
    // Whoever restores it begins anew to count how long nothing has changed.
    for (const char* sql :
         {"DELETE FROM preview WHERE flight_id=?", "DELETE FROM idle_flight WHERE flight_id=?",
          "UPDATE file SET preview_state=0 WHERE flight_id=? AND preview_state=1"}) {
      SKYQUILT_TRY(db->Change(sql, flight_id));
    }
    SKYQUILT_TRY(
        db->Change("UPDATE flight SET deleted_us=?2, deleted_age_us=?3 WHERE id=?1 AND deleted_us IS NULL",
                   flight_id, ToUs(now), age));
    if (db->Changes() == 0) return NoSuchFlight(flight_id);
    SKYQUILT_TRY(transaction.Commit());
    Record(flight_id, now);
    return true;
  });
}

Result<void> Trash::Restore(const std::string& flight_id) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(db->Change(
      "UPDATE flight SET deleted_us=NULL, deleted_age_us=NULL WHERE id=? AND deleted_us IS NOT NULL",
      flight_id));
  if (db->Changes() == 0) return NotInTrash(flight_id);
  Record(flight_id, std::nullopt);
  return {};
}

Result<std::vector<TrashedFlight>> Trash::List() const {
  const auto db = db_.Read();
  return db->All(TrashedFlightFrom, std::string(kTrashColumns) + "ORDER BY deleted_age_us DESC, id");
}

Result<TrashedFlight> Trash::Find(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->One(TrashedFlightFrom, NotInTrash(flight_id), std::string(kTrashColumns) + "AND id=?",
                 flight_id);
}

Result<std::vector<std::string>> Trash::DeletedUntil(Time age) const {
  const auto db = db_.Read();
  return db->AllText(
      "SELECT id FROM flight WHERE deleted_us IS NOT NULL AND deleted_age_us<=? ORDER BY deleted_age_us",
      ToUs(age));
}

}  // namespace skyquilt::storage
