#include "server/housekeeper.h"

#include <fmt/format.h>

#include "api/exports/exports.h"
#include "api/flights/trash.h"
#include "core/base/text/printable.h"
#include "server/routing/request_log.h"
#include "storage/folder/object_store/sweep_blobs.h"
#include "storage/folder/sweep.h"
#include "storage/uploads/upload_chunks.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::minutes kHousekeepingPause{5};
// It lists all that there is.
constexpr std::chrono::hours kBlobSweepPause{24};
// It counts the files of all flights.
constexpr std::chrono::hours kIdlePause{1};

// Says so where it was not done.
template <typename Done>
bool HasFailed(const char* what, const Result<Done>& done) {
  if (!done) LogFailure("-", what, done.error());
  return !done;
}

}  // namespace

Housekeeper::Housekeeper(api::Service& service)
    : service_(service), thread_([this] {
        for (; !thread_.IsEnded(); thread_.Rest(kHousekeepingPause)) Round();
      }) {}

void Housekeeper::TrashIdle() {
  const auto now = std::chrono::steady_clock::now();
  if (looked_idle_ && now - *looked_idle_ < kIdlePause) return;
  const Result<void> done = api::TrashIdleFlights(service_, [&](const storage::IdleFlight& flight) {
    LogEvent(fmt::format(
        "the flight \"{}\" had not changed for {} days and is in the trash now; for {} days it can be restored "
        "there on the page, or by POST /api/v1/flights/{}/restore",
        flight.name, service_.keep_days, service_.trash_days, flight.id));
  });
  if (HasFailed("flights that nobody changes", done)) return;
  looked_idle_ = now;
}

void Housekeeper::Round() {
  if (!service_.storage_in_place()) return;  // the folder is gone: what is removed now would be another's
  HasFailed("housekeeping", service_.db.SaveAges());
  HasFailed("housekeeping", service_.spool.RemoveExpired(service_.db.ages().Now()));
  const Result<int> removed = api::RemoveOldTrash(service_);
  if (!HasFailed("trash", removed) && *removed > 0)
    LogEvent(fmt::format("{} {} days ago and removed now",
                         Counted(*removed, "flight was deleted", "flights were deleted"),
                         service_.trash_days));
  TrashIdle();
  HasFailed("exports", api::RemoveExpiredExports(service_));
  service_.db.FillReserve();
  const auto now = std::chrono::steady_clock::now();
  if (swept_ && now - *swept_ < kBlobSweepPause) return;
  const Result<storage::SweepReport> work =
      storage::SweepWork(service_.store.dir(), service_.queue, storage::Now());
  if (HasFailed("sweep of work", work)) return;
  for (const std::string& line : work->moved) LogEvent(line);
  if (service_.store.blobs().IsFolder()) {
    swept_ = now;
    return;
  }
  const Result<storage::SweepReport> swept =
      storage::SweepBlobs(service_.store.blobs(), service_.catalogue, service_.queue, storage::Now());
  if (HasFailed("sweep of photos and maps", swept)) return;
  const Result<int> chunks = storage::SweepChunks(service_.db, service_.store.blobs(), storage::kOrphanAge);
  if (HasFailed("sweep of uploads", chunks)) return;
  const Result<int> orphans = storage::SweepExportBlobs(service_.store.blobs(), service_.catalogue,
                                                        service_.exports, storage::kOrphanAge);
  if (HasFailed("sweep of exports", orphans)) return;
  swept_ = now;
  if (const int removed_blobs = swept->removed + *chunks + *orphans; removed_blobs > 0)
    LogEvent(fmt::format("{} blobs that were nobody's were removed", removed_blobs));
  for (const std::string& line : swept->moved) LogEvent(line);
}

}  // namespace skyquilt::server
