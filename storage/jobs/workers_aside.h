// WorkersAside: which workers take nothing for a while because their machines were in trouble (disk, store,
// network), for how long and why, so that an operator sees it and the others go on. A worker says so itself,
// and takes it back with the next work that goes well. Any thread, any number of machines. Errors: as
// SqlConnection.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/catalogue_db.h"
#include "storage/db/clock.h"

namespace skyquilt::storage {

struct WorkerAside {
  std::string worker;
  Time since;        // its first trouble with nothing done since
  Time until;        // it tries again
  int times = 1;     // in a row
  std::string code;  // an ErrorCodeName
  std::string message;
};

// Before the n-th try: 5 seconds, doubled, ten minutes at most.
std::chrono::seconds PauseAside(int times);

class WorkersAside {
 public:
  explicit WorkersAside(CatalogueDb& db) : db_(db) {}
  Result<void> Put(const std::string& worker, int times, const Error& why, Time now);
  Result<void> Clear(const std::string& worker);
  // Those that have not come back; who was not heard of for an hour is left out, and forgotten.
  Result<std::vector<WorkerAside>> List() const;

 private:
  CatalogueDb& db_;
};

}  // namespace skyquilt::storage
