#include "storage/folder/open_data_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <set>
#include <system_error>

#include "core/base/try.h"
#include "storage/catalogue/catalogue.h"
#include "storage/db/ids.h"
#include "storage/files/publish_file.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/disk_flights.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/folder/shared_catalogue.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

bool IsEmptyFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) && fs::directory_iterator(path, error) == fs::directory_iterator() &&
         !error;
}

// A record or files in a folder named by an id: nobody else has such.
bool LooksLikeAFlight(const DiskFlight& flight) {
  std::error_code none;
  return HoldsAnything(flight) || fs::exists(flight.folder / kFlightRecordName, none);
}

Error OfOthers(const DataDir& dir, const FolderSurvey& survey) {
  std::string names;
  constexpr std::size_t kNamed = 3;
  for (std::size_t i = 0; i < std::min(survey.strangers.size(), kNamed); ++i) {
    names += (i == 0 ? "" : ", ") + survey.strangers[i];
  }
  if (survey.strangers.size() > kNamed)
    names += fmt::format(" and {} more", survey.strangers.size() - kNamed);
  return {
      ErrorCode::kConflict,
      fmt::format(
          "{} is not a data folder of Skyquilt: it has no skyquilt-data.json, but holds other things ({}). "
          "Choose a new or an empty folder with --data. Nothing in this one was changed.",
          dir.root().string(), names),
      ""};
}

Result<std::unique_ptr<CatalogueDb>> MakeCatalogue(const DataDir& dir, const std::string& id, int readers) {
  // Whole or not at all: under a name of its own until it is closed.
  const fs::path unfinished = dir.Catalogue().string() + ".new";
  {
    SKYQUILT_TRY_ASSIGN(const std::unique_ptr<CatalogueDb> db, CatalogueDb::Open(unfinished, 0));
    SKYQUILT_TRY(SetCatalogueId(*db->Lock(), id));
  }
  std::error_code none;  // its reserve, where the disk had room for one
  fs::rename(unfinished.string() + "-reserve", dir.Catalogue().string() + "-reserve", none);
  SKYQUILT_TRY(PublishFile(unfinished, dir.Catalogue()));
  return CatalogueDb::OpenExisting(dir.Catalogue(), readers);
}

// Errors with what to do about them.
Result<std::unique_ptr<CatalogueDb>> OpenCatalogue(const DataDir& dir, const CataloguePlace& place,
                                                   int readers = 2) {
  Result<std::unique_ptr<CatalogueDb>> db = OpenCatalogueOf(dir, place, readers);
  if (place.IsPostgres()) {
    if (db || db.error().code != ErrorCode::kNotFound) return db;
    return Error{db.error().code, db.error().message + " " + RepairAdvice(dir, place), db.error().detail};
  }
  if (!db && db.error().code == ErrorCode::kNotFound) {
    return Error{
        ErrorCode::kConflict,
        fmt::format("The catalogue {} is missing or empty. {}", dir.Catalogue().string(), RepairAdvice(dir)),
        ""};
  }
  if (!db && db.error().code == ErrorCode::kCorrupt) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("The catalogue {} is damaged. {}", dir.Catalogue().string(), RepairAdvice(dir)),
                 db.error().detail};
  }
  return db;
}

}  // namespace

Result<void> CheckWhole(const DataDir& dir, CatalogueDb& db) {
  if (db.IsShared()) return {};  // its server sees to that
  const auto access = db.Lock();
  SKYQUILT_TRY_ASSIGN(Statement query, access->Prepare("PRAGMA quick_check(1)"));
  const Result<bool> row = query.Step();
  if (row && *row && query.ColumnText(0) == "ok") return {};
  return Error{ErrorCode::kCorrupt,
               fmt::format("The catalogue {} is damaged. {}", dir.Catalogue().string(), RepairAdvice(dir)),
               row ? std::string(query.ColumnText(0)) : row.error().detail};
}

namespace {

// What a catalogue says of a flight, as far as it tells an older one apart.
struct KnownFlight {
  std::int64_t next_revision = 1;
  std::set<std::string> stored_names;
};

Result<std::map<std::string, KnownFlight>> KnownFlights(CatalogueDb& db) {
  const auto access = db.Lock();
  std::map<std::string, KnownFlight> flights;
  SKYQUILT_TRY_ASSIGN(Statement query, access->Query("SELECT id, next_revision FROM flight"));
  SKYQUILT_TRY(query.Each([&](const Statement& row) {
    flights[std::string(row.ColumnText(0))].next_revision = row.ColumnInt64(1);
  }));
  SKYQUILT_TRY_ASSIGN(Statement files, access->Query("SELECT flight_id, stored_name FROM file"));
  SKYQUILT_TRY(files.Each([&](const Statement& row) {
    flights[std::string(row.ColumnText(0))].stored_names.emplace(row.ColumnText(1));
  }));
  return flights;
}

// By stored name.
std::map<std::string, RecordedFile> RecordedAlone(const fs::path& flight_folder, const KnownFlight& known) {
  const Result<std::optional<FlightRecord>> record = ReadFlightRecord(flight_folder);
  if (!record || !*record) return {};
  std::map<std::string, RecordedFile> files = (*record)->files;
  std::erase_if(files, [&](const auto& file) {
    return file.second.is_removed || known.stored_names.contains(file.first);
  });
  return files;
}

// Files that the flight's record knows and the catalogue does not. `is_elsewhere`: they are not on the disk.
int UnknownFiles(const DiskFlight& flight, const KnownFlight& known, bool is_elsewhere) {
  std::set<std::string> unknown;
  for (const DiskFile& file : flight.files) {
    if (!known.stored_names.contains(file.stored_name)) unknown.insert(file.stored_name);
  }
  if (unknown.empty() && !is_elsewhere) return 0;
  const std::map<std::string, RecordedFile> alone = RecordedAlone(flight.folder, known);
  return static_cast<int>(std::count_if(alone.begin(), alone.end(), [&](const auto& file) {
    return is_elsewhere || unknown.contains(file.first);
  }));
}

// No crash leaves a flight with files that the catalogue never heard of (it is in the catalogue before its
// first file, and its record says so when it is deleted), nor a map with a number that was not given out, nor
// two files in records that are not in the catalogue (one is recorded at a time, just before it is
// committed). A catalogue from an older backup does, and what it does not know would be taken for lost.
Result<void> CheckIsLatest(const DataDir& dir, const CataloguePlace& place, CatalogueDb& db) {
  SKYQUILT_TRY_ASSIGN(const auto known, KnownFlights(db));
  std::error_code none;
  const bool is_elsewhere = fs::exists(dir.BlobsMarker(), none);  // then the records alone tell
  int flights = 0, files = 0, maps = 0;
  for (const DiskFlight& flight : FlightsOnDisk(dir.Flights())) {
    const auto found = known.find(flight.id);
    if (found != known.end()) {
      maps += static_cast<int>(
          std::count_if(flight.revisions.begin(), flight.revisions.end(),
                        [&](std::int64_t revision) { return revision >= found->second.next_revision; }));
      files += UnknownFiles(flight, found->second, is_elsewhere);
      continue;
    }
    if (!HoldsAnything(flight) && UnknownFiles(flight, {}, is_elsewhere) == 0) continue;
    const Result<std::optional<FlightRecord>> record = ReadFlightRecord(flight.folder);
    if (record && *record && ((*record)->is_deleted || (*record)->is_deleting)) continue;
    ++flights;
  }
  if (flights + maps == 0 && files < 2) return {};
  return Error{
      ErrorCode::kConflict,
      fmt::format(
          "The catalogue {} is older than what is on disk, or of another folder: {} flights, {} files of "
          "other flights and {} maps on disk are not in it. {}",
          NameOfCatalogue(dir, place), flights, files, maps, RepairAdvice(dir, place)),
      ""};
}

Result<OpenedDataFolder> MakeNewBesideShared(const DataDir& at, const CataloguePlace& place, int readers) {
  // Whose photos are there already has a catalogue: none is made for them.
  Result<std::unique_ptr<CatalogueDb>> db =
      place.files_of ? OpenCatalogueOf(at, place, readers) : MakeSharedCatalogue(at, place, readers);
  if (!db && db.error().code == ErrorCode::kNotFound && place.files_of)
    return OfAnotherCatalogue(place.files_at, *place.files_of, std::nullopt);
  if (!db) return db.error();
  Result<std::string> id = IdForNewFolder(**db, place);
  if (!id && !place.files_at.empty() && !place.files_of) {
    // Another that began at the same moment may have claimed the store since it was looked at.
    SKYQUILT_TRY_ASSIGN(const CataloguePlace now, WithFilesAt(place, {.address = place.files_at}));
    id = IdForNewFolder(**db, now);
  }
  if (!id) return id.error();
  SKYQUILT_TRY_ASSIGN(DataDir dir, DataDir::Open(at.root(), *id));
  SKYQUILT_TRY_ASSIGN(DataDirLock lock, DataDirLock::Take(dir));
  SKYQUILT_TRY(WriteMarker(dir, *id, /*is_shared=*/true));
  return OpenedDataFolder{std::move(dir), std::optional(std::move(lock)), *std::move(db), {}};
}

Result<OpenedDataFolder> MakeNew(const DataDir& at, const CataloguePlace& place, int readers) {
  if (place.files_of) return OfAnotherCatalogue(place.files_at, *place.files_of, std::nullopt);
  const std::string id = NewId();
  SKYQUILT_TRY_ASSIGN(DataDir dir, DataDir::Open(at.root(), id));
  SKYQUILT_TRY_ASSIGN(DataDirLock lock, DataDirLock::Take(dir));
  // The marker last: a folder that has one has had a catalogue.
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<CatalogueDb> db, MakeCatalogue(dir, id, readers));
  SKYQUILT_TRY(WriteMarker(dir, id));
  return OpenedDataFolder{std::move(dir), std::optional(std::move(lock)), std::move(db), {}};
}

}  // namespace

std::string RepairAdvice(const DataDir& dir, const CataloguePlace& place) {
  return fmt::format(
      "Put back a good copy of it, or run \"skyquilt data repair --data {}{}\", which makes the catalogue anew "
      "from the flights on disk. Nothing was changed or removed.",
      dir.root().string(), place.IsPostgres() ? " --catalogue " + place.url : "");
}

Result<int> WriteMissingRecords(const DataDir& dir, CatalogueDb& db) {
  const FlightRecords records(dir);
  const Catalogue catalogue(db);
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  int written = 0;
  for (const std::string& id : ids) {
    if (!IsId(id) || records.Has(id)) continue;
    SKYQUILT_TRY_ASSIGN(const FlightRecord record, catalogue.RecordOf(id));
    SKYQUILT_TRY(records.Begin(id, record));
    ++written;
  }
  return written;
}

Result<void> SettleRecords(const DataDir& dir, CatalogueDb& db) {
  const FlightRecords records(dir);
  if (!records.AreAllThatIsHere()) return {};  // the sweep takes their bytes away
  SKYQUILT_TRY_ASSIGN(const auto flights, KnownFlights(db));
  for (const auto& [id, known] : flights) {
    if (!IsId(id)) continue;
    const std::map<std::string, RecordedFile> alone = RecordedAlone(dir.Flight(id), known);
    if (alone.empty()) continue;
    SKYQUILT_TRY_ASSIGN(const FlightRecord whole, Catalogue(db).RecordOf(id));
    for (const auto& [stored_name, file] : alone) {
      (void)records.RemoveFile(id, stored_name).ok();  // on a full disk the next start does it
      for (const auto& [kept_name, kept] : whole.files) {
        if (kept.name == file.name) (void)records.AddFile(id, kept_name, kept).ok();
      }
    }
  }
  return {};
}

Result<FolderSurvey> SurveyFolder(const DataDir& dir) {
  const std::string root = dir.root().string();
  FolderSurvey survey;
  std::error_code error;
  const fs::file_status status = fs::status(dir.root(), error);
  if (status.type() == fs::file_type::not_found) {
    if (fs::is_symlink(fs::symlink_status(dir.root(), error))) {
      return Error{
          ErrorCode::kNotFound,
          "The data folder " + root +
              " is a link to a folder that does not exist. Mount the disk it leads to, or mend the link.",
          ""};
    }
    survey.is_new = true;
    return survey;
  }
  if (!fs::is_directory(status)) {
    return Error{ErrorCode::kConflict, "The path " + root + " is not a folder. Give a folder with --data.",
                 error.message()};
  }
  if (access(dir.root().c_str(), R_OK | W_OK | X_OK) != 0) {
    return Error{
        ErrorCode::kIo,
        fmt::format(
            "The data folder {} cannot be used by this user: {}. Change its owner or mode, or choose another "
            "with --data.",
            root, std::strerror(errno)),
        ""};
  }
  survey.exists = true;
  survey.is_new = true;
  const std::set<fs::path> folders = {dir.Flights(), dir.Uploads(), dir.Incoming(),
                                      dir.Work(),    dir.Lost(),    dir.Cache()};
  const std::set<std::string> files = {
      "blobs.json",       "blobs.json.tmp",           "skyquilt-data.json",   "skyquilt-data.json.tmp",
      "catalogue.db",     "catalogue.db-wal",         "catalogue.db-shm",     "catalogue.db-reserve",
      "catalogue.db.new", "catalogue.db.new-reserve", "catalogue.db.new-wal", "catalogue.db.new-shm",
      "server.lock"};
  for (const auto& entry : fs::directory_iterator(dir.root(), error)) {
    const std::string name = entry.path().filename().string();
    if (name == "lost+found") continue;  // what a file system makes at its root
    const bool is_folder_of_ours = folders.contains(entry.path());
    if (!is_folder_of_ours && !files.contains(name)) survey.strangers.push_back(name);
    if (is_folder_of_ours && !IsEmptyFolder(entry.path())) survey.is_new = false;
  }
  if (error)
    return Error{ErrorCode::kIo, fmt::format("The folder {} cannot be read: {}.", root, error.message()), ""};
  std::sort(survey.strangers.begin(), survey.strangers.end());
  for (const DiskFlight& flight : FlightsOnDisk(dir.Flights())) {
    survey.has_flights = survey.has_flights || LooksLikeAFlight(flight);
  }
  const std::uintmax_t bytes = fs::file_size(dir.Catalogue(), error);
  survey.has_catalogue = !error && bytes > 0;
  if (survey.has_catalogue || !survey.strangers.empty()) survey.is_new = false;
  return survey;
}

Result<OpenedDataFolder> OpenDataFolder(const fs::path& root, int readers, const CataloguePlace& place) {
  const DataDir at = DataDir::At(root);
  SKYQUILT_TRY_ASSIGN(const FolderSurvey survey, SurveyFolder(at));
  Result<std::optional<std::string>> marker = ReadMarker(at);
  if (!marker && marker.error().code == ErrorCode::kCorrupt) {
    return Error{ErrorCode::kCorrupt, marker.error().message + " " + RepairAdvice(at), ""};
  }
  if (!marker) return marker.error();
  if (!*marker && survey.is_new)
    return place.IsPostgres() ? MakeNewBesideShared(at, place, readers) : MakeNew(at, place, readers);
  if (!*marker && !survey.has_catalogue && !survey.has_flights) {
    FolderSurvey others = survey;
    if (others.strangers.empty()) others.strangers = {"flights, uploads or work that are not Skyquilt's"};
    return OfOthers(at, others);
  }
  SKYQUILT_TRY_ASSIGN(DataDirLock lock, DataDirLock::Take(at));
  Result<std::unique_ptr<CatalogueDb>> db = OpenCatalogue(at, place, readers);
  if (!db && !place.IsPostgres() && !*marker && !survey.has_flights && db.error().code != ErrorCode::kIo) {
    FolderSurvey others = survey;  // a catalogue.db of another program
    others.strangers.push_back("catalogue.db");
    return OfOthers(at, others);
  }
  if (!db) return db.error();
  SKYQUILT_TRY(CheckWhole(at, **db));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> owner, CatalogueId(*(*db)->Lock()));
  if (*marker && owner && **marker != *owner) {
    return Error{ErrorCode::kConflict,
                 fmt::format("The catalogue {} belongs to another data folder ({} instead of {}). {}",
                             NameOfCatalogue(at, place), *owner, **marker, RepairAdvice(at, place)),
                 ""};
  }
  if (!place.IsOfManyFolders()) {
    SKYQUILT_TRY(CheckIsLatest(at, place, **db));
  }
  if (place.IsPostgres() && !*marker) {
    SKYQUILT_TRY(CheckBlobsOf(*(*db)->Lock(), owner, place.files_at, place.files_of));
  }
  std::vector<std::string> notes;
  const std::string id = *marker ? **marker : owner ? *owner : NewId();
  if (!owner) {
    SKYQUILT_TRY(SetCatalogueId(*(*db)->Lock(), id));
  }
  if (!*marker) {
    SKYQUILT_TRY(WriteMarker(at, id, place.IsPostgres()));
    notes.push_back("the data folder had no marker; its catalogue knows the flights in it, so it got one");
  }
  SKYQUILT_TRY_ASSIGN(DataDir dir, DataDir::Open(root, id));
  return OpenedDataFolder{std::move(dir), std::optional(std::move(lock)), *std::move(db), std::move(notes)};
}

Result<OpenedDataFolder> JoinDataFolder(const fs::path& root, const CataloguePlace& place) {
  const DataDir at = DataDir::At(root);
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> marker, ReadMarker(at));
  if (!marker && place.IsOfManyFolders()) {
    SKYQUILT_TRY_ASSIGN(const FolderSurvey survey, SurveyFolder(at));
    if (!survey.is_new) return OfOthers(at, survey);
    SKYQUILT_TRY_ASSIGN(OpenedDataFolder made, MakeNewBesideShared(at, place, 2));
    made.lock.reset();
    return made;
  }
  if (!marker && place.IsPostgres()) {
    // Who forgot --blobs is told that.
    const Result<std::unique_ptr<CatalogueDb>> db = OpenCatalogue(at, place);
    if (db) SKYQUILT_TRY(CheckBlobsOf(*(*db)->Lock(), std::nullopt, place.files_at, place.files_of));
  }
  if (!marker) {
    return Error{
        ErrorCode::kNotFound,
        "The folder " + at.root().string() +
            " is not a data folder of Skyquilt: it has no skyquilt-data.json. Start a server on it to make one.",
        ""};
  }
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<CatalogueDb> db, OpenCatalogue(at, place));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> owner, CatalogueId(*db->Lock()));
  if (owner != marker) {
    return Error{ErrorCode::kConflict,
                 "The catalogue belongs to another data folder. " + RepairAdvice(at, place), ""};
  }
  return OpenedDataFolder{DataDir::At(root, *marker), std::nullopt, std::move(db), {}};
}

Result<OpenedDataFolder> OpenOrJoinDataFolder(const fs::path& root, const CataloguePlace& place) {
  const DataDir at = DataDir::At(root);
  const Result<std::optional<std::string>> marker = ReadMarker(at);
  if (marker && *marker && !DataDirLock::Take(at)) return JoinDataFolder(root, place);
  return OpenDataFolder(root, 2, place);
}

}  // namespace skyquilt::storage
