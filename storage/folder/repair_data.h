// RepairData: makes the catalogue of a data folder agree with what is on disk, without removing anything.
//   A catalogue that is missing, damaged or of another folder goes to lost/ and a new one takes its place;
//   one that can be used is kept and only added to (an older one, put back from a backup). One that only
//   cannot be opened now (a newer version wrote it, the disk is full) is left as it is, with an error.
//   Flights, files and maps that lie in lost/ come back to where they were. Flights, files and maps on disk
//   that the catalogue does not know are entered, by the flights' records (storage/catalogue/flight_record)
//   and the maps' own reports; files of flights without a whole record under the names that they are stored
//   by. Of several maps the newest that can be read is shown.
// Not brought back: what a record says the user deleted, and files that a whole record does not name, which
// were never accepted; they stay in lost/. Tokens, webhooks and jobs of a catalogue that is lost are lost
// with it. For a folder that no server uses at the moment (it takes the DataDirLock). May be run again after
// it was cut off.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/postgres/catalogue_place.h"

namespace skyquilt::storage {

struct RepairReport {
  bool made_catalogue = false;
  int flights = 0;  // that were entered
  int files = 0;
  int maps = 0;
  std::vector<std::string> lines;  // what was done, in order
};

// Errors: kNotFound, kConflict (not a data folder of ours, a server uses it, or a newer version wrote it),
// kUnavailable, kOutOfSpace, kIo.
Result<RepairReport> RepairData(const std::filesystem::path& root, Time now,
                                const CataloguePlace& place = {});

}  // namespace skyquilt::storage
