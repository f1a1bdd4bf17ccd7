#include "storage/folder/enter_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <string_view>

#include "core/base/try.h"
#include "storage/db/statement.h"
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

// "a.jpg" -> "a (2).jpg" while others have the name.
std::string FreeName(const std::string& name, const std::string& stored_name,
                     const std::set<std::string>& taken) {
  if (!taken.contains(name)) return name;
  const std::size_t dot = name.rfind('.');
  const std::string stem = dot == std::string::npos || dot == 0 ? name : name.substr(0, dot);
  return fmt::format("{} ({}){}", stem, stored_name, name.substr(stem.size()));
}

Result<bool> HasRow(SqlConnection& db, std::string_view sql, std::string_view first) {
  SKYQUILT_TRY_ASSIGN(Statement query, db.Prepare(sql));
  return query.Bind(1, first).Step();
}

// `age`: now, by the AgeClock: the days of a flight in the trash count anew.
Result<void> InsertFlight(SqlConnection& db, const DiskFlight& flight, const FlightRecord& record, Time age) {
  SKYQUILT_TRY_ASSIGN(
      Statement insert,
      db.Prepare("INSERT INTO flight(id,name,created_us,options,owner,deleted_us,deleted_age_us,tags,is_kept)"
                 " VALUES(?,?,?,?,?,?,?,?,?)"));
  Time created = record.created.value_or(Time{});
  if (!record.created) {
    for (const DiskFile& file : flight.files) {
      if (created == Time{} || file.changed < created) created = file.changed;
    }
  }
  const std::string name = record.name.value_or("Recovered flight " + flight.id);
  const std::string options = record.options.value_or("{}");
  const std::string owner = record.owner.value_or("");
  insert.Bind(1, flight.id).Bind(2, name).Bind(3, ToUs(created)).Bind(4, options).Bind(5, owner);
  insert.Bind(8, TagsText(record.tags.value_or(std::vector<std::string>())));
  insert.Bind(9, static_cast<std::int64_t>(record.is_kept.value_or(false)));
  if (record.trashed) {
    insert.Bind(6, ToUs(*record.trashed)).Bind(7, ToUs(age));
  } else {
    insert.BindNull(6).BindNull(7);
  }
  return insert.Run();
}

Result<std::set<std::string>> NamesOf(SqlConnection& db, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(Statement query, db.Prepare("SELECT name FROM file WHERE flight_id=?"));
  query.Bind(1, flight_id);
  std::set<std::string> names;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return names;
    names.emplace(query.ColumnText(0));
  }
}

Result<void> InsertFiles(SqlConnection& db, const DiskFlight& flight, const FlightRecord& record,
                         EnteredFlight& entered) {
  SKYQUILT_TRY_ASSIGN(std::set<std::string> names, NamesOf(db, flight.id));
  std::set<std::string> stored;
  for (const DiskFile& file : flight.files) stored.insert(file.stored_name);
  SKYQUILT_TRY_ASSIGN(
      Statement insert,
      db.Prepare("INSERT INTO file(flight_id,name,bytes,stored_name,created_us) VALUES(?,?,?,?,?)"));
  for (const DiskFile& file : flight.files) {
    SKYQUILT_TRY_ASSIGN(const bool is_known,
                        HasRow(db, "SELECT 1 FROM file WHERE stored_name=?", file.stored_name));
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
    SKYQUILT_TRY(insert.Bind(1, flight.id)
                     .Bind(2, name)
                     .Bind(3, file.bytes)
                     .Bind(4, file.stored_name)
                     .Bind(5, ToUs(created))
                     .Run());
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
    SKYQUILT_TRY_ASSIGN(const bool was_known, forget.Bind(1, flight_id).Bind(2, stored_name).Step());
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
  SKYQUILT_TRY_ASSIGN(Statement forget, db.Prepare("DELETE FROM revision WHERE flight_id=? AND revision=?"));
  SKYQUILT_TRY(forget.Bind(1, flight_id).Bind(2, map.revision).Run());
  SKYQUILT_TRY_ASSIGN(Statement insert,
                      db.Prepare("INSERT INTO revision VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"));
  insert.Bind(1, flight_id).Bind(2, map.revision).Bind(3, ToUs(map.created));
  insert.Bind(4, map.bounds.west_deg).Bind(5, map.bounds.south_deg);
  insert.Bind(6, map.bounds.east_deg).Bind(7, map.bounds.north_deg);
  insert.Bind(8, map.min_zoom).Bind(9, map.max_zoom).Bind(10, map.gsd_m);
  insert.Bind(11, map.photos_total).Bind(12, map.photos_aligned);
  insert.Bind(13, map.photos_pose_only).Bind(14, map.photos_left_out);
  insert.Bind(15, map.first_capture).Bind(16, map.last_capture).Bind(17, map.quality);
  SKYQUILT_TRY(insert.Run());
  for (const char* sql :
       {"DELETE FROM preview WHERE flight_id=?", "UPDATE file SET preview_state=2 WHERE flight_id=?"}) {
    SKYQUILT_TRY_ASSIGN(Statement statement, db.Prepare(sql));
    SKYQUILT_TRY(statement.Bind(1, flight_id).Run());
  }
  SKYQUILT_TRY_ASSIGN(Statement show, db.Prepare("UPDATE flight SET active_revision=?2 WHERE id=?1"));
  return show.Bind(1, flight_id).Bind(2, map.revision).Run();
}

// The newest map that can be read, unless that is the one which is shown.
Result<void> ShowNewestMap(SqlConnection& db, const DiskFlight& flight, EnteredFlight& entered) {
  std::int64_t active = 0;
  {
    SKYQUILT_TRY_ASSIGN(Statement query,
                        db.Prepare("SELECT coalesce(active_revision, 0) FROM flight WHERE id=?"));
    SKYQUILT_TRY(query.Bind(1, flight.id).Step());
    active = query.ColumnInt64(0);
  }
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
  SKYQUILT_TRY_ASSIGN(Statement next,
                      db.Prepare("UPDATE flight SET next_revision=?2 WHERE id=?1 AND next_revision<?2"));
  return next.Bind(1, flight.id).Bind(2, flight.revisions.back() + 1).Run();
}

}  // namespace

Result<EnteredFlight> EnterFlight(CatalogueDb& catalogue, const DiskFlight& flight,
                                  const std::optional<FlightRecord>& record) {
  const auto db = catalogue.Lock();
  SKYQUILT_TRY_ASSIGN(Transaction transaction, Transaction::Begin(*db, flight.id));
  EnteredFlight entered;
  SKYQUILT_TRY_ASSIGN(const bool is_known, HasRow(*db, "SELECT 1 FROM flight WHERE id=?", flight.id));
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
