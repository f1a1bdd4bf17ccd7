// EnterFlight: adds one flight that is on disk to the catalogue, as far as it is missing there: the flight,
// its files by the names in its record, its newest map. In one transaction. Errors: kOutOfSpace,
// kUnavailable, kIo.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/flight_record.h"
#include "storage/db/catalogue_db.h"
#include "storage/folder/disk_flights.h"

namespace skyquilt::storage {

struct EnteredFlight {
  bool is_new = false;
  int files = 0;
  std::optional<std::int64_t> revision;  // the map that is shown now and was not before
  std::vector<std::string> notes;        // what could not be entered
};

// `record`: absent where the flight has none.
Result<EnteredFlight> EnterFlight(CatalogueDb& db, const DiskFlight& flight,
                                  const std::optional<FlightRecord>& record);

}  // namespace skyquilt::storage
