#include "storage/jobs/workers_aside.h"

#include <algorithm>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

constexpr std::int64_t kForgottenAfterUs = std::int64_t{3'600} * 1'000'000;

}  // namespace

std::chrono::seconds PauseAside(int times) {
  constexpr std::chrono::seconds kFirst{5}, kLongest{600};
  return std::min(kLongest, kFirst * (1 << std::clamp(times - 1, 0, 10)));
}

Result<void> WorkersAside::Put(const std::string& worker, int times, const Error& why, Time by_machine) {
  const auto db = db_.Lock();
  const Time now = db_.SharedTime(by_machine, *db);
  SKYQUILT_TRY(db->Change("DELETE FROM worker_aside WHERE until_us<?", ToUs(now) - kForgottenAfterUs));
  return db->Change(
      "INSERT INTO worker_aside(worker,since_us,until_us,times,code,message) VALUES(?1,?2,?3,?4,?5,?6)"
      " ON CONFLICT(worker) DO UPDATE SET until_us=excluded.until_us, times=excluded.times,"
      " code=excluded.code, message=excluded.message",
      worker, ToUs(now), ToUs(now + PauseAside(times)), times, ErrorCodeName(why.code), why.message);
}

Result<void> WorkersAside::Clear(const std::string& worker) {
  const auto db = db_.Lock();
  return db->Change("DELETE FROM worker_aside WHERE worker=?", worker);
}

Result<std::vector<WorkerAside>> WorkersAside::List() const {
  const auto db = db_.Read();
  const Time now = db_.SharedTime(Now(), *db);
  return db->All(RowOf<WorkerAside, std::string, Time, Time, int, std::string, std::string>,
                 "SELECT worker, since_us, until_us, times, code, message FROM worker_aside"
                 " WHERE until_us>=? ORDER BY since_us, worker LIMIT 1000",
                 ToUs(now) - kForgottenAfterUs);
}

}  // namespace skyquilt::storage
