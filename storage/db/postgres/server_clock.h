// ServerClock: what the clock of the catalogue's database shows, from this machine's and the difference that
// was measured. Leases end by it, so that machines whose clocks differ agree who holds a job. Measured again
// every half minute, and at once where this machine's clock was set (it and the time since the machine
// started then disagree). A difference below half a second, which is as much the way there as the clocks,
// counts as none. Any thread.
#pragma once

#include <chrono>
#include <functional>
#include <mutex>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/db/sql_connection.h"

namespace skyquilt::storage {

class ServerClock {
 public:
  // `local`: the clock of this machine; another one for tests.
  explicit ServerClock(std::function<Time()> local = Now) : local_(std::move(local)) {}
  // What the server's clock shows when this machine's shows `here`. Where the server cannot be asked, or
  // takes a second to answer, by the last difference that was measured.
  Time At(Time here, SqlConnection& db);

 private:
  struct Measured {
    std::chrono::microseconds difference{0};
    Time local;
    std::chrono::microseconds elapsed{0};  // since the machine started
  };
  Result<Measured> Measure(SqlConnection& db) const;

  const std::function<Time()> local_;
  std::mutex mutex_;
  bool was_measured_ = false;
  Measured measured_;
};

}  // namespace skyquilt::storage
