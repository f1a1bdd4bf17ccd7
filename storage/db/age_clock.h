// AgeClock: the time by which stored things expire (abandoned uploads, kept answers, the trash). It advances
// only while the machine runs, by the kernel's time since boot, and is stored in the catalogue from one start
// to the next: setting the machine's clock, however wrong, expires nothing. It stands still while the machine
// is off, so things are kept longer than promised, never shorter. It started near the machine's clock but
// need not agree with it: times shown to people go through OnTheWall. Any thread, any number of processes:
// all read the same. Errors: as SqliteDb.
#pragma once

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sqlite_db.h"

namespace skyquilt::storage {

class AgeClock {
 public:
  static Result<AgeClock> Open(SqliteDb& db);

  Time Now() const;
  // What the machine's clock will show when this one shows `age`.
  Time OnTheWall(Time age) const { return storage::Now() + (age - Now()); }
  // So that a power cut takes back no more than what passed since.
  Result<void> Save(SqliteDb& db) const;

 private:
  explicit AgeClock(Time at_boot) : at_boot_(at_boot) {}
  Time at_boot_;  // what it would have shown when the machine started
};

}  // namespace skyquilt::storage
