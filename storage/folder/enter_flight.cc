#include "storage/folder/enter_flight.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <set>
#include <string_view>

#include "core/base/text/file_names.h"
#include "core/base/try.h"
#include "storage/db/sql_connection.h"
#include "storage/tags/flight_tags.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// Stored names have no ending; people and programs that take the file out again want one.
std::string NameByContent(const fs::path& path, const std::string& stored_name) {
  std::array<char, 12> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), head.size());
  const std::string_view text(head.data(), head.size());
  using namespace std::string_view_literals;
  if (text.starts_with("\xff\xd8\xff"sv)) return stored_name + ".jpg";
  if (text.starts_with("\x89PNG"sv)) return stored_name + ".png";
  if (text.starts_with("II*\0"sv) || text.starts_with("MM\0*"sv)) return stored_name + ".tif";
  if (text.starts_with("PK\x03\x04"sv)) return stored_name + ".zip";
  return stored_name;
}

std::string FreeName(const std::string& name, const std::string& stored_name,
                     const std::set<std::string>& taken) {
  return taken.contains(name) ? NumberedName(name, stored_name) : name;
}

// `age`: now, by the AgeClock: the days of a flight in the trash count anew.
Result<void> InsertFlight(SqlConnection& db, const DiskFlight& flight, const FlightRecord& record, Time age) {
  Time created = record.created.value_or(Time{});
  if (!record.created) {
    for (const DiskFile& file : flight.files) {
      if (created == Time{} || file.changed < created) created = file.changed;
    }
  }
  std::optional<std::int64_t> deleted_us, deleted_age_us;
  if (record.trashed) {
    deleted_us = ToUs(*record.trashed);
    deleted_age_us = ToUs(age);
  }
  return db.Change(
      "INSERT INTO flight(id,name,created_us,options,owner,deleted_us,deleted_age_us,tags,is_kept)"
      " VALUES(?,?,?,?,?,?,?,?,?)",
      flight.id, record.name.value_or("Recovered flight " + flight.id), ToUs(created),
      record.options.value_or("{}"), record.owner.value_or(""), deleted_us, deleted_age_us,
      TagsText(record.tags.value_or(std::vector<std::string>())), record.is_kept.value_or(false));
}

Result<void> InsertFiles(SqlConnection& db, const DiskFlight& flight, const FlightRecord& record,
                         EnteredFlight& entered) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> known,
                      db.AllText("SELECT name FROM file WHERE flight_id=?", flight.id));
  std::set<std::string> names(known.begin(), known.end()), stored;
  for (const DiskFile& file : flight.files) stored.insert(file.stored_name);
  SKYQUILT_TRY_ASSIGN(
      Statement insert,
      db.Prepare("INSERT INTO file(flight_id,name,bytes,stored_name,created_us) VALUES(?,?,?,?,?)"));
  for (const DiskFile& file : flight.files) {
    SKYQUILT_TRY_ASSIGN(const bool is_known,
                        db.Finds("SELECT 1 FROM file WHERE stored_name=?", file.stored_name));
    if (is_known) continue;
    const auto recorded = record.files.find(file.stored_name);
    if (recorded == record.files.end()
            ? record.is_whole
            : recorded->second.is_removed || stored.contains(recorded->second.replaced_by)) {
      continue;
    }
    std::string name = NameByContent(flight.folder / "files" / file.stored_name, file.stored_name);
    Time created = file.changed;
    if (recorded != record.files.end() && CheckFileName(recorded->second.name)) {
      name = recorded->second.name;
      created = recorded->second.created;
    }
    if (recorded != record.files.end() && recorded->second.bytes != file.bytes) {
      entered.notes.push_back(fmt::format("flights/{}/files/{} ({}) has {} bytes instead of {}", flight.id,
                                          file.stored_name, name, file.bytes, recorded->second.bytes));
    }
    name = FreeName(name, file.stored_name, names);
    names.insert(name);
    SKYQUILT_TRY(insert.BindAll(flight.id, name, file.bytes, file.stored_name, ToUs(created)).Run());
    ++entered.files;
  }
  return {};
}

// A catalogue of yesterday still has the files that were removed or replaced since.
Result<void> ForgetRemovedFiles(SqlConnection& db, const std::string& flight_id, const FlightRecord& record,
                                EnteredFlight& entered) {
  SKYQUILT_TRY_ASSIGN(Statement forget,
                      db.Prepare("DELETE FROM file WHERE flight_id=? AND stored_name=? RETURNING name"));
  for (const auto& [stored_name, recorded] : record.files) {
    if (!recorded.is_removed) continue;
    SKYQUILT_TRY_ASSIGN(const bool was_known, forget.BindAll(flight_id, stored_name).Step());
    if (was_known) {
      entered.notes.push_back(
          fmt::format("flight {}: {} was removed or replaced later than this catalogue knows", flight_id,
                      forget.ColumnText(0)));
    }
    forget.Reset();
  }
  return {};
}

Result<void> ShowMap(SqlConnection& db, const std::string& flight_id, const Revision& map) {
  SKYQUILT_TRY(db.Change("DELETE FROM revision WHERE flight_id=? AND revision=?", flight_id, map.revision));
  SKYQUILT_TRY(ShowRevision(db, flight_id, map, map.created));
  return db.Change("UPDATE file SET preview_state=2 WHERE flight_id=?", flight_id);
}

// The newest map that can be read, unless that is the one which is shown.
Result<void> ShowNewestMap(SqlConnection& db, const DiskFlight& flight, EnteredFlight& entered) {
  SKYQUILT_TRY_ASSIGN(const std::int64_t active,
                      db.Number("SELECT coalesce(active_revision, 0) FROM flight WHERE id=?", flight.id));
  for (auto number = flight.revisions.rbegin(); number != flight.revisions.rend() && *number != active;
       ++number) {
    const Result<Revision> map = RevisionOnDisk(flight.folder / RevisionFolderName(*number), *number);
    if (!map) {
      entered.notes.push_back(
          fmt::format("flights/{}/{} is no map that can be read", flight.id, RevisionFolderName(*number)));
      continue;
    }
    SKYQUILT_TRY(ShowMap(db, flight.id, *map));
    entered.revision = *number;
    break;
  }
  if (flight.revisions.empty()) return {};
  // A number that lies on disk is never given out again.
  return db.Change("UPDATE flight SET next_revision=?2 WHERE id=?1 AND next_revision<?2", flight.id,
                   flight.revisions.back() + 1);
}

}  // namespace

Result<EnteredFlight> EnterFlight(CatalogueDb& catalogue, const DiskFlight& flight,
                                  const std::optional<FlightRecord>& record) {
  const auto db = catalogue.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight.id));
  EnteredFlight entered;
  SKYQUILT_TRY_ASSIGN(const bool is_known, db->Finds("SELECT 1 FROM flight WHERE id=?", flight.id));
  const FlightRecord facts = record.value_or(FlightRecord());
  entered.is_new = !is_known;
  if (entered.is_new) {
    SKYQUILT_TRY(InsertFlight(*db, flight, facts, catalogue.ages().Now()));
  }
  SKYQUILT_TRY(ForgetRemovedFiles(*db, flight.id, facts, entered));
  SKYQUILT_TRY(InsertFiles(*db, flight, facts, entered));
  SKYQUILT_TRY(ShowNewestMap(*db, flight, entered));
  SKYQUILT_TRY(transaction.Commit());
  return entered;
}

}  // namespace skyquilt::storage
