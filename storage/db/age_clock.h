// AgeClock: the time by which stored things expire (abandoned uploads, kept answers, the trash). It advances
// only while the machine runs, by the kernel's time since boot, and is stored in the catalogue from one start
// to the next: setting the machine's clock, however wrong, expires nothing. It stands still while the machine
// is off, so things are kept longer than promised, never shorter. It started near the machine's clock but
// need not agree with it: times shown to people go through OnTheWall. Any thread, any number of processes:
// all read the same.
//
// In PostgreSQL, where many machines share a catalogue, it goes by the database's clock from one Save to the
// next, by an hour at most: a clock that is set ahead by years takes the ages an hour ahead, once, and one
// that is set back stops them until the next Save. Between, each process goes on by its own machine's time
// since boot. It stands still while no server runs. Errors: as SqlConnection.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"

namespace skyquilt::storage {

class AgeClock {
 public:
  static Result<AgeClock> Open(SqlConnection& db);
  AgeClock(const AgeClock& other) : at_boot_us_(other.at_boot_us_.load()) {}
  AgeClock& operator=(const AgeClock&) = delete;

  Time Now() const;
  // What the machine's clock will show when this one shows `age`.
  Time OnTheWall(Time age) const { return storage::Now() + (age - Now()); }
  // So that a power cut takes back no more than what passed since.
  Result<void> Save(SqlConnection& db);

 private:
  explicit AgeClock(Time at_boot) : at_boot_us_(ToUs(at_boot)) {}
  std::atomic<std::int64_t> at_boot_us_;  // what it would have shown when the machine started
};

}  // namespace skyquilt::storage
