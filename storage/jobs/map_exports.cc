#include "storage/jobs/map_exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/catalogue/tokens.h"
#include "storage/db/ids.h"
#include "storage/files/data_dir.h"
#include "storage/jobs/job_rows.h"

namespace skyquilt::storage {
namespace {

constexpr std::array<const char*, 4> kStates = {"accepted", "running", "successful", "failed"};

constexpr const char* kExportColumns =
    "e.id, e.flight_id, e.revision, e.request, e.format, e.owner, e.progress, e.attempts, e.lease_token, "
    "e.bytes, e.error_code, e.error_message, e.created_us, e.finished_us, e.expires_us, "
    "EXISTS(SELECT 1 FROM token t WHERE t.id=e.owner AND t.flight_id IS NOT NULL) AS is_of_link, "
    "e.error_reason, e.state";

MapExport ExportOf(const Statement& row) {
  MapExport made;
  std::string state;
  row.Into(made.id, made.flight_id, made.revision, made.request, made.format, made.owner, made.progress,
           made.attempts, made.lease_token, made.bytes, made.error_code, made.error_message, made.created,
           made.finished, made.expires, made.is_of_link, made.error_reason, state);
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    if (state == kStates[i]) made.state = static_cast<ExportState>(i);
  }
  return made;
}

// Room for the next export of a link, of which it has one.
Result<void> MakeRoomForLink(SqlConnection& db, const MapExport& wish, const std::vector<MapExport>& known) {
  SKYQUILT_TRY_ASSIGN(const bool is_there,
                      db.Finds("SELECT 1 FROM token WHERE id=? AND flight_id IS NOT NULL", wish.owner));
  if (!is_there)
    return Error{ErrorCode::kForbidden, "This link has ended. Ask whoever sent it for another.", ""};
  for (const MapExport& one : known) {
    if (one.owner == wish.owner && !one.HasEnded())
      return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kExportOneOfLink);
  }
  return EndExportsOf(db, wish.owner);
}

Result<std::vector<MapExport>> ListOf(SqlConnection& db, const std::string& flight_id) {
  return db.All(
      ExportOf,
      fmt::format("SELECT {} FROM map_export e WHERE e.flight_id=? ORDER BY e.id DESC", kExportColumns),
      flight_id);
}

}  // namespace

const char* NameOf(ExportState state) { return kStates.at(static_cast<std::size_t>(state)); }

Result<MapExport> MapExports::Add(const MapExport& wish, Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, wish.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<MapExport> known, ListOf(*db, wish.flight_id));
  for (const MapExport& one : known) {
    const bool is_the_same =
        one.revision == wish.revision && one.request == wish.request && one.state != ExportState::kFailed;
    if (!is_the_same || HasExpired(one)) continue;
    MapExport there = one;
    if (one.is_of_link && !wish.is_of_link) {
      SKYQUILT_TRY(db->Change("UPDATE map_export SET owner=?2 WHERE id=?1", one.id, wish.owner));
      SKYQUILT_TRY(transaction.Commit());
      there.owner = wish.owner;
      there.is_of_link = false;
    }
    return there;
  }
  if (wish.is_of_link) {
    SKYQUILT_TRY(MakeRoomForLink(*db, wish, known));
  } else if (std::count_if(known.begin(), known.end(),
                           [](const MapExport& one) { return !one.is_of_link; }) >= kMaxOfFlight) {
    return flight::Because(ErrorCode::kConflict,
                           {flight::RemarkCode::kExportsOfFlight, {{"most", kMaxOfFlight}}});
  }
  SKYQUILT_TRY_ASSIGN(const std::int64_t open,
                      db->Number("SELECT count(*) FROM map_export e JOIN flight f ON f.id=e.flight_id"
                                 " WHERE e.state IN ('accepted','running') AND f.deleted_us IS NULL"));
  if (open >= kMaxOpen) return flight::Because(ErrorCode::kRateLimited, flight::RemarkCode::kExportsOfServer);
  MapExport added = wish;
  added.id = NewId();
  added.state = ExportState::kAccepted;
  added.created = now;
  SKYQUILT_TRY(db->Change(
      "INSERT INTO map_export(id,flight_id,revision,request,format,owner,state,created_us)"
      " VALUES(?,?,?,?,?,?,'accepted',?)",
      added.id, added.flight_id, added.revision, added.request, added.format, added.owner, ToUs(now)));
  SKYQUILT_TRY(transaction.Commit());
  has_new_ = true;
  return added;
}

Result<MapExport> MapExports::Get(const std::string& flight_id, const std::string& id) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(std::optional<MapExport> found,
                      db->First(ExportOf,
                                fmt::format("SELECT {} FROM map_export e JOIN flight f ON f.id=e.flight_id"
                                            " WHERE e.id=? AND e.flight_id=? AND f.deleted_us IS NULL",
                                            kExportColumns),
                                id, flight_id));
  if (!found || HasExpired(*found))
    return flight::Because(ErrorCode::kNotFound, flight::RemarkCode::kExportGone);
  return *std::move(found);
}

Result<std::vector<MapExport>> MapExports::List(const std::string& flight_id) const {
  const auto db = db_.Read();
  return ListOf(*db, flight_id);
}

Result<void> MapExports::Remove(const std::string& id) {
  const auto db = db_.Lock();
  return db->Change("DELETE FROM map_export WHERE id=?", id);
}

Result<std::optional<MapExport>> MapExports::Claim(Time now, bool prints) {
  const bool had_new = has_new_.exchange(false);
  Result<std::optional<MapExport>> claimed = ClaimOnce(now, prints);
  if (!claimed && had_new) has_new_ = true;  // it is still there
  return claimed;
}

Result<std::optional<MapExport>> MapExports::ClaimOnce(Time now, bool prints) {
  const auto db = db_.Lock();
  const Time time = db_.SharedTime(now, *db);
  while (true) {
    SKYQUILT_TRY_ASSIGN(
        std::optional<MapExport> next,
        db->First(ExportOf,
                  fmt::format("SELECT {} FROM map_export e JOIN flight f ON f.id=e.flight_id"
                              " WHERE e.state IN ('accepted','running') AND"
                              " e.lease_until_us<CASE e.state WHEN 'running' THEN ?2 ELSE ?1 END"
                              " AND f.deleted_us IS NULL{} ORDER BY is_of_link, e.id LIMIT 1",
                              kExportColumns, prints ? "" : " AND e.format<>'report'"),
                  ToUs(time), ToUs(db_.LostBefore(time))));
    if (!next) return next;
    SKYQUILT_TRY(
        db->Change("UPDATE map_export SET state='running', progress=0, attempts=attempts+1,"
                   " lease_token=lease_token+1, lease_until_us=?3 WHERE id=?1 AND lease_token=?2",
                   next->id, next->lease_token, ToUs(time + kLease)));
    if (db->Changes() == 0) continue;  // another server was faster
    next->state = ExportState::kRunning;
    ++next->lease_token;
    if (next->attempts++ < kMaxAttempts) return next;
    SKYQUILT_TRY(db->Change(
        "UPDATE map_export SET state='failed', error_code='internal', error_message=?2, finished_us=?3,"
        " expires_us=?4 WHERE id=?1",
        next->id, "The server ended while it made this export, more than once. Ask for it again.", ToUs(now),
        ToUs(db_.ages().Now() + kKept)));
  }
}

Result<bool> MapExports::Heartbeat(const MapExport& claimed, double progress, Time now) {
  const auto db = db_.Lock();
  const Time time = db_.SharedTime(now, *db);
  SKYQUILT_TRY(
      db->Change("UPDATE map_export SET progress=?3, lease_until_us=?4 WHERE id=?1 AND lease_token=?2"
                 " AND state='running'",
                 claimed.id, claimed.lease_token, progress, ToUs(time + kLease)));
  return db->Changes() > 0;
}

Result<bool> MapExports::End(const MapExport& claimed, ExportState state, std::int64_t bytes,
                             const Error& error, Time now) {
  const auto db = db_.Lock();
  const bool is_good = state == ExportState::kSuccessful;
  const std::string_view code = is_good ? std::string_view() : ErrorCodeName(error.code);
  SKYQUILT_TRY(db->Change(
      "UPDATE map_export SET state=?3, progress=?4, bytes=?5, error_code=?6, error_message=?7,"
      " finished_us=?8, expires_us=?9, error_reason=?10 WHERE id=?1 AND lease_token=?2 AND state='running'",
      claimed.id, claimed.lease_token, NameOf(state), is_good ? 1.0 : 0.0, bytes, code, error.message,
      ToUs(now), ToUs(db_.ages().Now() + kKept), is_good ? std::string() : ReasonText(error)));
  return db->Changes() > 0;
}

Result<bool> MapExports::Succeed(const MapExport& claimed, std::int64_t bytes, Time now) {
  return End(claimed, ExportState::kSuccessful, bytes, Error{}, now);
}

Result<bool> MapExports::Fail(const MapExport& claimed, const Error& error, Time now) {
  return End(claimed, ExportState::kFailed, 0, error, now);
}

Result<bool> MapExports::GiveBack(const MapExport& claimed) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(
      db->Change("UPDATE map_export SET state='accepted', progress=0, attempts=attempts-1,"
                 " lease_until_us=0 WHERE id=? AND lease_token=? AND state='running'",
                 claimed.id, claimed.lease_token));
  return db->Changes() > 0;
}

Result<void> MapExports::TakeUpAfterRestart() {
  const auto db = db_.Lock();
  return db->Exec("UPDATE map_export SET state='accepted', lease_until_us=0 WHERE state='running'");
}

Result<void> MapExports::EndThoseOfEndedLinks(Time now) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(
      const std::vector<std::string> ended,
      db->AllText(
          "SELECT id FROM token WHERE flight_id IS NOT NULL AND expires_us<=? AND EXISTS("
          "SELECT 1 FROM map_export e WHERE e.owner=token.id AND (e.expires_us IS NULL OR e.expires_us>0))",
          ToUs(now)));
  if (ended.empty()) return {};
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db));
  for (const std::string& owner : ended) SKYQUILT_TRY(EndExportsOf(*db, owner));
  return transaction.Commit();
}

Result<std::vector<MapExport>> MapExports::Expired() const {
  const auto db = db_.Read();
  return db->All(
      ExportOf, fmt::format("SELECT {} FROM map_export e WHERE e.expires_us<? ORDER BY e.id", kExportColumns),
      ToUs(db_.ages().Now()));
}

std::string ExportKey(const MapExport& made) {
  const std::string ending = made.format == "geotiff" ? "tif" : made.format;
  return fmt::format("{}{}/{}.{}", FlightPrefix(made.flight_id), kExportsFolder, made.id, ending);
}

}  // namespace skyquilt::storage
