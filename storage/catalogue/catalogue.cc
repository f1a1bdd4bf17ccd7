#include "storage/catalogue/catalogue.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "core/base/text/file_names.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "storage/db/ids.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kIsThere = "SELECT 1 FROM flight WHERE id=? AND deleted_us IS NULL";
constexpr const char* kFlightColumns =
    "SELECT f.id, f.name, f.options, f.created_us, f.active_revision,"
    " (SELECT count(*) FROM file WHERE flight_id=f.id),"
    " (SELECT coalesce(sum(bytes),0) FROM file WHERE flight_id=f.id), f.owner, f.tags, f.is_kept"
    " FROM flight f ";

Flight FlightFrom(const Statement& row) {
  Flight flight;
  std::string tags;
  row.Into(flight.id, flight.name, flight.options, flight.created, flight.active_revision, flight.file_count,
           flight.bytes, flight.owner, tags, flight.is_kept);
  flight.tags = TagsFrom(tags);
  return flight;
}

Result<Flight> ReadFlight(SqlConnection& db, const std::string& id) {
  return db.One(FlightFrom, NoSuchFlight(id),
                std::string(kFlightColumns) + "WHERE f.id=? AND f.deleted_us IS NULL", id);
}

// Up to `limit` rows after the cursor, the query's first two parameters, by rising or falling id; where
// others follow, the cursor of the next page.
template <typename Item, typename Read, typename IdOf>
Result<std::optional<std::string>> ReadPage(Statement& query, int limit,
                                            const std::optional<std::string>& cursor,
                                            std::vector<Item>& items, const Read& read, const IdOf& id_of) {
  query.BindAll(cursor, limit + 1);  // one extra row shows whether another page follows
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return std::optional<std::string>();
    if (static_cast<int>(items.size()) == limit) return std::optional<std::string>(id_of(items.back()));
    items.push_back(read(query));
  }
}

Result<void> RequireNotRunning(SqlConnection& db, const std::string& flight_id) {
  // A waiting job that is locked cannot begin before this transaction ends.
  SKYQUILT_TRY_ASSIGN(
      const std::vector<std::string> states,
      db.AllText(std::string("SELECT state FROM job WHERE flight_id=? AND state IN ('accepted','running')") +
                     db.ForShare(),
                 flight_id));
  if (std::find(states.begin(), states.end(), "running") == states.end()) return {};
  return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kFailBeingStitched);
}

Result<void> InsertFile(SqlConnection& db, const std::string& flight_id, const StoredFile& file, Time now) {
  SKYQUILT_TRY(db.Change("INSERT INTO file(flight_id,name,bytes,stored_name,created_us) VALUES(?,?,?,?,?)",
                         flight_id, file.name, file.bytes, file.stored_name, ToUs(now)));
  // What a running job's units are made from now on, its digest does not tell.
  return db.Change(
      "UPDATE job SET made_from='' WHERE flight_id=? AND state IN ('accepted','running') AND made_from<>''",
      flight_id);
}

Result<std::optional<StoredFile>> FileNamed(SqlConnection& db, const std::string& flight_id,
                                            const std::string& name) {
  return db.First(FileFrom, "SELECT name, stored_name, bytes FROM file WHERE flight_id=? AND name=?",
                  flight_id, name);
}

// Of the revision that each flight shows, in the order of RevisionFrom.
constexpr const char* kRevisionColumns =
    "r.revision, r.created_us, west, south, east, north, min_zoom, max_zoom, gsd_m, photos_total,"
    " photos_aligned, photos_pose_only, photos_left_out, first_capture, last_capture, quality";
constexpr const char* kShownRevisions =
    " FROM flight f JOIN revision r ON r.flight_id=f.id AND r.revision=f.active_revision ";

Revision RevisionFrom(const Statement& row) {
  Revision revision;
  auto& [west, south, east, north] = revision.bounds;
  row.Into(revision.revision, revision.created, west, south, east, north, revision.min_zoom,
           revision.max_zoom, revision.gsd_m, revision.photos_total, revision.photos_aligned,
           revision.photos_pose_only, revision.photos_left_out, revision.first_capture, revision.last_capture,
           revision.quality);
  return revision;
}

Error ChangedElsewhere(const std::string& name) {
  return {ErrorCode::kPreconditionFailed, fmt::format("The file {} was changed elsewhere meanwhile.", name),
          ""};
}

}  // namespace

Error NoSuchFlight(const std::string& id) {
  return {ErrorCode::kNotFound, fmt::format("There is no flight {}.", id), ""};
}

Result<void> RequireFlight(SqlConnection& db, const std::string& id) {
  SKYQUILT_TRY_ASSIGN(const bool known, db.Finds(kIsThere, id));
  if (!known) return NoSuchFlight(id);
  return {};
}

StoredFile FileFrom(const Statement& row) {
  return RowOf<StoredFile, std::string, std::string, std::int64_t>(row);
}

Result<void> ShowRevision(SqlConnection& db, const std::string& flight_id, const Revision& revision,
                          Time created) {
  const geo::LatLonBounds& bounds = revision.bounds;
  SKYQUILT_TRY(db.Change("INSERT INTO revision VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)", flight_id,
                         revision.revision, ToUs(created), bounds.west_deg, bounds.south_deg, bounds.east_deg,
                         bounds.north_deg, revision.min_zoom, revision.max_zoom, revision.gsd_m,
                         revision.photos_total, revision.photos_aligned, revision.photos_pose_only,
                         revision.photos_left_out, revision.first_capture, revision.last_capture,
                         revision.quality));
  SKYQUILT_TRY(db.Change("DELETE FROM preview WHERE flight_id=?", flight_id));
  return db.Change("UPDATE flight SET active_revision=?2 WHERE id=?1", flight_id, revision.revision);
}

Result<void> Catalogue::Record(const std::string& flight_id, const StoredFile& file, Time now) const {
  if (!records_) return {};
  return records_->AddFile(flight_id, file.stored_name, {file.name, file.bytes, now, false});
}

Result<void> Catalogue::SettleRecord(SqlConnection& db, const std::string& flight_id, const StoredFile& file,
                                     const Error& why) const {
  if (db.WasUndoneByOthers()) return why;  // it is done again
  const auto there =
      db.First([](const Statement& row) { return std::pair(FileFrom(row), row.Get<Time>(3)); },
               "SELECT name, stored_name, bytes, created_us FROM file WHERE flight_id=? AND name=?",
               flight_id, file.name);
  if (!there) return why;  // nobody knows now
  if (*there && (*there)->first.stored_name == file.stored_name) return {};
  // A start takes a catalogue that lacks several recorded files for an older one.
  if (records_) (void)records_->RemoveFile(flight_id, file.stored_name).ok();
  if (*there) (void)Record(flight_id, (*there)->first, (*there)->second).ok();
  return why;
}

Result<Flight> Catalogue::AddFlight(const std::string& name, const std::string& options, Time now,
                                    const std::string& owner, const FlightChange& marks) {
  const auto db = db_.Lock();
  Flight flight;
  flight.id = NewId();
  flight.name = name;
  flight.options = options;
  flight.created = now;
  flight.owner = owner;
  flight.tags = marks.tags.value_or(std::vector<std::string>());
  flight.is_kept = marks.is_kept.value_or(false);
  if (records_) {
    FlightRecord record;
    record.tags = marks.tags;
    record.is_kept = marks.is_kept;
    record.name = name;
    record.options = options;
    record.owner = owner;
    record.created = now;
    SKYQUILT_TRY(records_->Begin(flight.id, record));
  }
  const Result<void> done =
      db->Change("INSERT INTO flight(id,name,created_us,options,owner,tags,is_kept) VALUES(?,?,?,?,?,?,?)",
                 flight.id, name, ToUs(now), options, owner, TagsText(flight.tags), flight.is_kept);
  if (!done && records_) records_->Undo(flight.id);
  if (!done) return done.error();
  return flight;
}

Result<std::int64_t> Catalogue::BytesOf(const std::string& owner) const {
  const auto db = db_.Read();
  return db->Number(
      "SELECT (SELECT coalesce(sum(bytes),0) FROM file JOIN flight f ON f.id=flight_id WHERE f.owner=?1)"
      " + (SELECT coalesce(sum(coalesce(length,byte_offset)),0) FROM upload JOIN flight f ON f.id=flight_id"
      "    WHERE f.owner=?1 AND is_done=0)"
      " + (SELECT coalesce(sum(coalesce(length,byte_offset)),0) FROM upload WHERE flight_id IS NULL AND owner=?1)",
      owner);
}

Result<std::string> Catalogue::OwnerOf(const std::string& flight_id) const {
  const auto db = db_.Lock();
  return db->One(FirstColumn<std::string>, NoSuchFlight(flight_id), "SELECT owner FROM flight WHERE id=?",
                 flight_id);
}

Result<Flight> Catalogue::GetFlight(const std::string& id) const {
  const auto db = db_.Read();
  return ReadFlight(*db, id);
}

Result<FlightPage> Catalogue::ListFlights(int limit, const std::optional<std::string>& cursor,
                                          const std::optional<std::string>& tag) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(
          std::string(kFlightColumns) +
          "WHERE (CAST(?1 AS TEXT) IS NULL OR f.id < ?1) AND f.deleted_us IS NULL"
          " AND (CAST(?3 AS TEXT) IS NULL OR replace(f.tags,?3,'')<>f.tags) ORDER BY f.id DESC LIMIT ?2"));
  query.Bind(3, tag ? std::optional(TagsText({*tag})) : std::nullopt);
  FlightPage page;
  SKYQUILT_TRY_ASSIGN(page.next_cursor, ReadPage(query, limit, cursor, page.flights, FlightFrom,
                                                 [](const Flight& flight) { return flight.id; }));
  return page;
}

Result<void> Catalogue::ChangeFlight(const std::string& id, const FlightChange& change) {
  const auto db = db_.Lock();
  SKYQUILT_TRY(
      db->Change("UPDATE flight SET name=coalesce(?2,name), options=coalesce(?3,options),"
                 " tags=coalesce(?4,tags), is_kept=coalesce(?5,is_kept)"
                 " WHERE id=?1 AND deleted_us IS NULL",
                 id, change.name, change.options,
                 change.tags ? std::optional(TagsText(*change.tags)) : std::nullopt, change.is_kept));
  if (db->Changes() == 0) return NoSuchFlight(id);
  if (!records_) return {};
  FlightRecord line;
  line.name = change.name;
  line.options = change.options;
  line.tags = change.tags;
  line.is_kept = change.is_kept;
  return records_->Change(id, line);
}

Result<void> Catalogue::DeleteFlight(const std::string& id, std::optional<Time> trashed_until) {
  const auto until_us = trashed_until ? std::optional(ToUs(*trashed_until)) : std::nullopt;
  const std::string wanted = "id=?1 AND (CAST(?2 AS BIGINT) IS NULL OR deleted_age_us<=?2)";
  return db_.Again([&]() -> Result<void> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, id));
    SKYQUILT_TRY_ASSIGN(const bool known, db->Finds("SELECT 1 FROM flight WHERE " + wanted, id, until_us));
    if (!known) return NoSuchFlight(id);
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> uploads,
                        db->AllText("SELECT id FROM upload WHERE flight_id=?", id));
    // What the record cannot take (a full disk, the one thing that deleting mends) must not keep the flight:
    // the record only tells a repair of a lost catalogue not to bring the flight back.
    if (records_) (void)records_->Deleting(id, Now()).ok();
    Result<void> done = db->Change("DELETE FROM flight WHERE " + wanted, id, until_us);
    if (done && db->Changes() == 0) done = NoSuchFlight(id);  // another server restored it just now
    if (done) done = transaction.Commit();
    if (!done && records_) (void)records_->Change(id, {}).ok();
    if (!done) return done.error();
    if (!records_) return {};
    (void)records_->Deleted(id, Now()).ok();
    // Its resumable uploads went with it; bytes that stay here, the next start moves to lost/.
    for (const std::string& upload : uploads) unlink((records_->dir().Uploads() / upload).c_str());
    return {};
  });
}

Result<bool> Catalogue::HasFlight(const std::string& id) const {
  const auto db = db_.Read();
  return db->Finds(kIsThere, id);
}

Result<std::vector<std::string>> Catalogue::FlightIds() const {
  const auto db = db_.Read();
  return db->AllText("SELECT id FROM flight ORDER BY id");
}

Result<AddedFile> Catalogue::AddFile(const std::string& flight_id, const StoredFile& file, Time now,
                                     const std::optional<std::string>& expected) {
  return db_.Again([&]() -> Result<AddedFile> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight_id));
    SKYQUILT_TRY(RequireFlight(*db, flight_id));
    AddedFile added;
    SKYQUILT_TRY_ASSIGN(const std::optional<StoredFile> old, FileNamed(*db, flight_id, file.name));
    if (old) added = {true, old->stored_name, old->bytes};
    if (expected && *expected != added.replaced_stored_name) return ChangedElsewhere(file.name);
    if (added.replaced) {
      SKYQUILT_TRY(RequireNotRunning(*db, flight_id));
      SKYQUILT_TRY(db->Change("DELETE FROM file WHERE flight_id=? AND name=?", flight_id, file.name));
    }
    SKYQUILT_TRY(InsertFile(*db, flight_id, file, now));
    SKYQUILT_TRY(Record(flight_id, file, now));
    const Result<void> committed = transaction.Commit();
    if (!committed) SKYQUILT_TRY(SettleRecord(*db, flight_id, file, committed.error()));
    if (added.replaced && records_)
      (void)records_->RemoveFile(flight_id, added.replaced_stored_name).ok();  // as below
    return added;
  });
}

Result<StoredFile> Catalogue::AddFileUnderFreeName(const std::string& flight_id, const StoredFile& file,
                                                   Time now, const std::optional<std::string>& upload_id) {
  return db_.Again([&]() -> Result<StoredFile> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight_id));
    SKYQUILT_TRY(RequireFlight(*db, flight_id));
    StoredFile added = file;
    for (int number = 2;; ++number) {
      SKYQUILT_TRY_ASSIGN(const bool taken, db->Finds("SELECT 1 FROM file WHERE flight_id=? AND name=?",
                                                      flight_id, added.name));
      if (!taken) break;
      // Thousands of equal names must not cost thousands of look-ups each: then our own unique name is the
      // mark.
      constexpr int kMaxNumbers = 20;
      added.name = NumberedName(file.name, number <= kMaxNumbers ? std::to_string(number) : file.stored_name);
    }
    SKYQUILT_TRY(InsertFile(*db, flight_id, added, now));
    if (upload_id) {
      SKYQUILT_TRY(db->Change("UPDATE upload SET is_done=1 WHERE id=? AND is_done=0", *upload_id));
      if (db->Changes() == 0)
        return Error{ErrorCode::kConflict, "This upload was finished or removed meanwhile.", ""};
    }
    SKYQUILT_TRY(Record(flight_id, added, now));
    const Result<void> committed = transaction.Commit();
    if (!committed) SKYQUILT_TRY(SettleRecord(*db, flight_id, added, committed.error()));
    return added;
  });
}

Result<StoredFile> Catalogue::RemoveFile(const std::string& flight_id, const std::string& name,
                                         const std::optional<std::string>& expected) {
  return db_.Again([&]() -> Result<StoredFile> {
    const auto db = db_.Lock();
    SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight_id));
    SKYQUILT_TRY(RequireFlight(*db, flight_id));
    SKYQUILT_TRY(RequireNotRunning(*db, flight_id));
    SKYQUILT_TRY_ASSIGN(
        const auto gone,
        db->One(
            [](const Statement& row) { return std::pair(FileFrom(row), row.Get<Time>(3)); },
            {ErrorCode::kNotFound, fmt::format("This flight has no file \"{}\".", name), ""},
            "DELETE FROM file WHERE flight_id=? AND name=? RETURNING name, stored_name, bytes, created_us",
            flight_id, name));
    const auto& [removed, created] = gone;
    if (expected && *expected != removed.stored_name) return ChangedElsewhere(name);
    // Before the catalogue: a process that dies between the two must not leave a record that brings the file
    // back. A record that cannot take it (a full disk) still names a file that is about to go, which does no
    // harm where a start sees that it is gone.
    const Result<void> recorded =
        records_ ? records_->RemoveFile(flight_id, removed.stored_name) : Result<void>();
    const bool is_without = !recorded && recorded.error().code == ErrorCode::kNotFound;
    if (!recorded && !is_without && records_->AreAllThatIsHere()) return recorded.error();
    const bool is_recorded = records_ && recorded;
    const Result<void> committed = transaction.Commit();
    if (!committed) {
      if (is_recorded) (void)Record(flight_id, removed, created).ok();  // what it would say is not so
      return committed.error();
    }
    return removed;
  });
}

Result<std::optional<StoredFile>> Catalogue::FindFile(const std::string& flight_id,
                                                      const std::string& name) const {
  const auto db = db_.Read();
  return FileNamed(*db, flight_id, name);
}

Result<std::vector<StoredFile>> Catalogue::ListFiles(const std::string& flight_id) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(const bool known, db->Finds("SELECT 1 FROM flight WHERE id=?", flight_id));
  if (!known) return NoSuchFlight(flight_id);
  return db->All(FileFrom, "SELECT name, stored_name, bytes FROM file WHERE flight_id=? ORDER BY name",
                 flight_id);
}

Result<FlightRecord> Catalogue::RecordOf(const std::string& flight_id) const {
  const auto db = db_.Lock();
  const auto record_from = [](const Statement& row) {
    FlightRecord flight;
    std::string tags;
    row.Into(flight.name, flight.options, flight.owner, flight.created, flight.trashed, tags, flight.is_kept);
    flight.tags = TagsFrom(tags);
    return flight;
  };
  SKYQUILT_TRY_ASSIGN(
      FlightRecord record,
      db->One(record_from, NoSuchFlight(flight_id),
              "SELECT name, options, owner, created_us, deleted_us, tags, is_kept FROM flight WHERE id=?",
              flight_id));
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Query("SELECT stored_name, name, bytes, created_us FROM file WHERE flight_id=?", flight_id));
  SKYQUILT_TRY(query.Each([&](const Statement& row) {
    record.files[std::string(row.ColumnText(0))] = {std::string(row.ColumnText(1)), row.ColumnInt64(2),
                                                    FromUs(row.ColumnInt64(3)), false};
  }));
  return record;
}

Result<std::optional<Revision>> Catalogue::ActiveRevision(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->First(
      RevisionFrom,
      std::string("SELECT ") + kRevisionColumns + kShownRevisions + "WHERE f.id=? AND f.deleted_us IS NULL",
      flight_id);
}

Result<MapPage> Catalogue::ListMaps(int limit, const std::optional<std::string>& cursor) const {
  const auto db = db_.Read();
  SKYQUILT_TRY_ASSIGN(
      Statement query,
      db->Prepare(std::string("SELECT ") + kRevisionColumns + ", f.id, f.name, f.tags" + kShownRevisions +
                  "WHERE (CAST(?1 AS TEXT) IS NULL OR f.id < ?1) AND f.deleted_us IS NULL "
                  "ORDER BY f.id DESC LIMIT ?2"));
  const auto map_from = [](const Statement& row) {
    constexpr int kNext = 16;  // behind what RevisionFrom reads
    return ShownFlight{std::string(row.ColumnText(kNext)), std::string(row.ColumnText(kNext + 1)),
                       RevisionFrom(row), TagsFrom(row.ColumnText(kNext + 2))};
  };
  MapPage page;
  SKYQUILT_TRY_ASSIGN(page.next_cursor, ReadPage(query, limit, cursor, page.maps, map_from,
                                                 [](const ShownFlight& map) { return map.flight_id; }));
  return page;
}

Result<std::vector<std::int64_t>> Catalogue::Revisions(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->All(FirstColumn<std::int64_t>,
                 "SELECT revision FROM revision WHERE flight_id=? ORDER BY revision", flight_id);
}

Result<std::int64_t> Catalogue::NextRevision(const std::string& flight_id) const {
  const auto db = db_.Read();
  return db->One(FirstColumn<std::int64_t>, NoSuchFlight(flight_id),
                 "SELECT next_revision FROM flight WHERE id=?", flight_id);
}

}  // namespace skyquilt::storage
