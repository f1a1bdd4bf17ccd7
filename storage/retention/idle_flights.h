// IdleFlights: since when nothing has changed in a flight. Look compares each flight with what was seen of
// it before, and keeps in the table idle_flight since when it is so. A change is another name, other options
// or tags, a file added, replaced or removed (notes and control points are files), a job, another map. A
// flight is in use while it is marked to be kept, a job of it waits or runs, a resumable upload of it is
// open, an export of it exists, or a share of it has not ended; it is then never idle, and its days begin
// when the use was last seen. Looking at a map is neither. Days count by the AgeClock, and from the first
// Look on: no clock that is wrong makes a flight idle. A flight that goes to the trash begins anew when it is
// restored. Any thread, any number of processes. Errors: kOutOfSpace, kUnavailable, kIo.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"

namespace skyquilt::storage {

struct IdleFlight {
  std::string id;
  std::string name;
};

class IdleFlights {
 public:
  explicit IdleFlights(CatalogueDb& db) : db_(db) {}

  // Looks at all flights that are not in the trash. Those that were idle for `keep` are the answer, in the
  // order of their ids. `age`: now by the AgeClock; `now`: by the machine's clock, by which shares end.
  Result<std::vector<IdleFlight>> Look(Time age, Time now, std::chrono::microseconds keep);
  // Whether one of them still is, read through `db`: for a transaction that puts it into the trash.
  static Result<bool> IsIdle(SqlConnection& db, const std::string& flight_id, Time age, Time now,
                             std::chrono::microseconds keep);
  // All days begin anew with the next Look. For a server that keeps every flight.
  Result<void> Forget();

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
