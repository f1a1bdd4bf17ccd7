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
  SKYQUILT_TRY_ASSIGN(Statement forget, db->Prepare("DELETE FROM worker_aside WHERE until_us<?"));
  SKYQUILT_TRY(forget.Bind(1, ToUs(now) - kForgottenAfterUs).Run());
  SKYQUILT_TRY_ASSIGN(
      Statement put,
      db->Prepare(
          "INSERT INTO worker_aside(worker,since_us,until_us,times,code,message) VALUES(?1,?2,?3,?4,?5,?6)"
          " ON CONFLICT(worker) DO UPDATE SET until_us=excluded.until_us, times=excluded.times,"
          " code=excluded.code, message=excluded.message"));
  return put.Bind(1, worker)
      .Bind(2, ToUs(now))
      .Bind(3, ToUs(now + PauseAside(times)))
      .Bind(4, times)
      .Bind(5, ErrorCodeName(why.code))
      .Bind(6, why.message)
      .Run();
}

Result<void> WorkersAside::Clear(const std::string& worker) {
  const auto db = db_.Lock();
  SKYQUILT_TRY_ASSIGN(Statement clear, db->Prepare("DELETE FROM worker_aside WHERE worker=?"));
  return clear.Bind(1, worker).Run();
}

Result<std::vector<WorkerAside>> WorkersAside::List() const {
  const auto db = db_.Read();
  const Time now = db_.SharedTime(Now(), *db);
  SKYQUILT_TRY_ASSIGN(Statement query,
                      db->Prepare("SELECT worker, since_us, until_us, times, code, message FROM worker_aside"
                                  " WHERE until_us>=? ORDER BY since_us, worker LIMIT 1000"));
  query.Bind(1, ToUs(now) - kForgottenAfterUs);
  std::vector<WorkerAside> workers;
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, query.Step());
    if (!row) return workers;
    workers.push_back({std::string(query.ColumnText(0)), FromUs(query.ColumnInt64(1)),
                       FromUs(query.ColumnInt64(2)), static_cast<int>(query.ColumnInt64(3)),
                       std::string(query.ColumnText(4)), std::string(query.ColumnText(5))});
  }
}

}  // namespace skyquilt::storage
