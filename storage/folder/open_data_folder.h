// Opening a data folder, and refusing one that is not ours or not whole, before anything in it is changed:
//   new or empty                              it is made ours: marker and catalogue
//   things of others, no marker               kConflict
//   marker and catalogue of one id            opened
//   catalogue of a version without markers    adopted, where it knows the flights on disk
//   catalogue missing, empty, damaged, of another folder, or older than the flights on disk
//                                             kConflict or kCorrupt, naming "skyquilt data repair"
// With a catalogue in PostgreSQL (CataloguePlace) the same is asked of that one; a catalogue.db beside it is
// left alone. Each message says what to do. Nothing is ever removed. Other errors: kIo, kOutOfSpace.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

struct OpenedDataFolder {
  DataDir dir;
  std::optional<DataDirLock> lock;  // absent for who joined
  std::unique_ptr<CatalogueDb> db;
  std::vector<std::string> notes;  // what was done to the folder, for the log
};

// For its one server. kConflict also where another has it. `readers`: as of CatalogueDb::Open.
Result<OpenedDataFolder> OpenDataFolder(const std::filesystem::path& root, int readers = 2,
                                        const CataloguePlace& place = {});
// For a process beside the server, which made the folder what it is: nothing is made or adopted, but a new
// folder for a machine of its own where files lie elsewhere.
Result<OpenedDataFolder> JoinDataFolder(const std::filesystem::path& root, const CataloguePlace& place = {});
// As its server where there is none at the moment, else beside it.
Result<OpenedDataFolder> OpenOrJoinDataFolder(const std::filesystem::path& root,
                                              const CataloguePlace& place = {});

// Flights of versions that wrote no records get theirs while the catalogue still knows their names; how many.
// For the server of a folder with the flights' files, once nothing can refuse it.
Result<int> WriteMissingRecords(const DataDir& dir, CatalogueDb& db);
// Where photos lie elsewhere, the records alone say what a catalogue lacks: what killed servers recorded and
// did not commit is said to be removed, so that it does not add up. For the same server, before it takes
// requests.
Result<void> SettleRecords(const DataDir& dir, CatalogueDb& db);

// "Run "skyquilt data repair --data DIR"...": what helps where the catalogue and the flights do not agree.
std::string RepairAdvice(const DataDir& dir, const CataloguePlace& place = {});
// kCorrupt where the pages of a catalogue in the folder do not fit together.
Result<void> CheckWhole(const DataDir& dir, CatalogueDb& db);

struct FolderSurvey {
  bool exists = false;
  bool is_new = false;                 // nothing in it that matters
  bool has_flights = false;            // folders in it look like flights of ours
  bool has_catalogue = false;          // a file of that name that is not empty
  std::vector<std::string> strangers;  // names in the folder that are none of ours
};
// What is in a folder that may not be ours. Errors: kNotFound (a link to nothing), kConflict (no folder), kIo
// (not to be read or written by this user).
Result<FolderSurvey> SurveyFolder(const DataDir& dir);

}  // namespace skyquilt::storage
