#include "storage/folder/repair_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <system_error>

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/disk_flights.h"
#include "storage/folder/enter_flight.h"
#include "storage/folder/lost_folder.h"
#include "storage/folder/open_data_folder.h"
#include "storage/folder/shared_catalogue.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// The catalogue, if it can be gone on with; null where it is to be made anew, and `why` says what it is. An
// error where it may be whole: it is a newer version's, the disk is full, another program has it.
Result<std::unique_ptr<CatalogueDb>> UsableCatalogue(const DataDir& dir,
                                                     const std::optional<std::string>& marker,
                                                     std::string& why) {
  Result<std::unique_ptr<CatalogueDb>> db = CatalogueDb::OpenExisting(dir.Catalogue());
  if (!db && db.error().code != ErrorCode::kNotFound && db.error().code != ErrorCode::kCorrupt)
    return db.error();
  why = "is missing, empty or damaged";
  if (!db || !CheckWhole(dir, **db)) return std::unique_ptr<CatalogueDb>();
  const Result<std::optional<std::string>> owner = CatalogueId(*(*db)->Lock());
  if (!owner) return std::unique_ptr<CatalogueDb>();
  why = "belongs to another data folder";
  if (marker && *owner && *marker != **owner) return std::unique_ptr<CatalogueDb>();
  return db;
}

Result<std::unique_ptr<CatalogueDb>> TakeCatalogue(const DataDir& dir, std::optional<std::string>& marker,
                                                   LostFolder& lost, RepairReport& report) {
  std::string why;
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<CatalogueDb> db, UsableCatalogue(dir, marker, why));
  if (db != nullptr) {
    SKYQUILT_TRY_ASSIGN(const std::optional<std::string> owner, CatalogueId(*db->Lock()));
    if (!marker) marker = owner;
  } else {
    std::error_code none;
    for (const char* ending : {"", "-wal", "-shm"}) {
      const fs::path path = dir.Catalogue().string() + ending;
      if (!fs::exists(fs::symlink_status(path, none))) continue;
      report.lines.push_back(lost.Take(path, why));
      if (fs::exists(fs::symlink_status(path, none))) {
        return Error{
            ErrorCode::kIo,
            "The file " + path.string() + " could not be moved away. Move it to a safe place, and try again.",
            ""};
      }
    }
    SKYQUILT_TRY_ASSIGN(db, CatalogueDb::Open(dir.Catalogue()));
    report.made_catalogue = true;
    report.lines.push_back("a new catalogue was made; tokens and webhooks are to be added again");
  }
  if (!marker) marker = NewId();
  SKYQUILT_TRY(SetCatalogueId(*db->Lock(), *marker));
  return db;
}

// One that is another folder's is never taken over: its flights are elsewhere.
Result<std::unique_ptr<CatalogueDb>> TakeSharedCatalogue(const DataDir& dir,
                                                         std::optional<std::string>& marker,
                                                         const CataloguePlace& place) {
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<CatalogueDb> db, MakeSharedCatalogue(dir, place));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> owner, CatalogueId(*db->Lock()));
  if (owner && marker && *owner != *marker) {
    return Error{
        ErrorCode::kConflict,
        "The catalogue in the database of --catalogue belongs to another data folder. Give that folder with "
        "--data, or another database or schema. Nothing was changed.",
        ""};
  }
  if (!marker) marker = owner ? owner : NewId();
  SKYQUILT_TRY(SetCatalogueId(*db->Lock(), *marker));
  return db;
}

void Move(const fs::path& from, const fs::path& to, const DataDir& dir, RepairReport& report) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(to, error))) return;
  fs::create_directories(to.parent_path(), error);
  if (!error) fs::rename(from, to, error);
  report.lines.push_back(
      fmt::format("{} {}", from.lexically_relative(dir.root()).string(),
                  error ? "could not be brought back: " + error.message() : std::string("was brought back")));
}

// What lies of one flight in one folder of lost/ comes back to where it was.
Result<void> BringBack(const DataDir& dir, const DiskFlight& lost, RepairReport& report) {
  const fs::path home = dir.Flight(lost.id);
  std::error_code none;
  const bool has_home = fs::exists(home, none);
  SKYQUILT_TRY_ASSIGN(std::optional<FlightRecord> record, ReadFlightRecord(has_home ? home : lost.folder));
  if (record && record->is_deleted) {
    report.lines.push_back(fmt::format("{} was deleted by its owner and stays there",
                                       lost.folder.lexically_relative(dir.root()).string()));
    return {};
  }
  if (!has_home) {
    if (HoldsAnything(lost)) Move(lost.folder, home, dir, report);
    return {};
  }
  const FlightRecord facts = record.value_or(FlightRecord());
  for (const DiskFile& file : lost.files) {
    const auto found = facts.files.find(file.stored_name);
    if (found == facts.files.end() ? facts.is_whole : found->second.is_removed) continue;
    Move(lost.folder / "files" / file.stored_name, home / "files" / file.stored_name, dir, report);
  }
  for (const std::int64_t revision : lost.revisions) {
    Move(lost.folder / RevisionFolderName(revision), home / RevisionFolderName(revision), dir, report);
  }
  return {};
}

Result<void> BringBackAll(const DataDir& dir, RepairReport& report) {
  std::vector<LostItem> items = ListLost(dir);
  std::reverse(items.begin(), items.end());  // the latest of two of one name
  for (const LostItem& item : items) {
    for (const DiskFlight& flight : FlightsOnDisk(item.folder / "flights")) {
      SKYQUILT_TRY(BringBack(dir, flight, report));
    }
  }
  return {};
}

Result<void> Enter(const DataDir& dir, CatalogueDb& db, const DiskFlight& flight, LostFolder& lost,
                   RepairReport& report) {
  SKYQUILT_TRY_ASSIGN(const std::optional<FlightRecord> record, ReadFlightRecord(flight.folder));
  SKYQUILT_TRY_ASSIGN(const bool is_known, Catalogue(db).HasFlight(flight.id));
  if (!is_known && (!HoldsAnything(flight) || (record && record->is_deleted))) return {};
  SKYQUILT_TRY_ASSIGN(const EnteredFlight entered, EnterFlight(db, flight, record));
  for (const std::string& note : entered.notes) report.lines.push_back(note);
  report.flights += entered.is_new ? 1 : 0;
  report.files += entered.files;
  report.maps += entered.revision ? 1 : 0;
  if (entered.is_new || entered.files > 0 || entered.revision) {
    report.lines.push_back(fmt::format(
        "flight {}{}: {} files{}", flight.id, entered.is_new ? " is known again" : "", entered.files,
        entered.revision ? fmt::format(", map r{} is shown", *entered.revision) : ""));
  }
  if (record && record->is_whole) return {};
  if (record) report.lines.push_back(lost.Take(flight.folder / kFlightRecordName, "is damaged"));
  SKYQUILT_TRY_ASSIGN(const FlightRecord whole, Catalogue(db).RecordOf(flight.id));
  return FlightRecords(dir).Begin(flight.id, whole);
}

}  // namespace

Result<RepairReport> RepairData(const fs::path& root, Time now, const CataloguePlace& place) {
  const DataDir at = DataDir::At(root);
  SKYQUILT_TRY_ASSIGN(const FolderSurvey survey, SurveyFolder(at));
  if (!survey.exists) {
    return Error{ErrorCode::kNotFound,
                 "There is no folder " + at.root().string() + ". Give the data folder with --data.", ""};
  }
  Result<std::optional<std::string>> read = ReadMarker(at);
  if (read && *read && !place.IsPostgres() && HasSharedCatalogue(at)) return WantsItsCatalogue(at);
  const bool is_damaged = !read && read.error().code == ErrorCode::kCorrupt;
  if (!read && !is_damaged) return read.error();
  std::optional<std::string> marker = is_damaged ? std::nullopt : *read;
  const bool has_lost = !ListLost(at).empty();
  if (!marker && !is_damaged && !survey.has_flights &&
      !(survey.strangers.empty() && (survey.has_catalogue || has_lost))) {
    return Error{ErrorCode::kConflict,
                 "The folder " + at.root().string() +
                     " is not a data folder of Skyquilt: it has neither skyquilt-data.json nor flights.",
                 ""};
  }
  SKYQUILT_TRY_ASSIGN(const DataDirLock lock, DataDirLock::Take(at));
  RepairReport report;
  LostFolder lost(at, now);
  if (is_damaged) report.lines.push_back(lost.Take(at.Marker(), "is damaged"));
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<CatalogueDb> db, place.IsPostgres()
                                                           ? TakeSharedCatalogue(at, marker, place)
                                                           : TakeCatalogue(at, marker, lost, report));
  SKYQUILT_TRY(WriteMarker(at, *marker, place.IsPostgres()));
  SKYQUILT_TRY_ASSIGN(const DataDir dir, DataDir::Open(at.root(), *marker));
  SKYQUILT_TRY(BringBackAll(dir, report));
  for (const DiskFlight& flight : FlightsOnDisk(dir.Flights())) {
    SKYQUILT_TRY(Enter(dir, *db, flight, lost, report));
  }
  return report;
}

}  // namespace skyquilt::storage
