#include "server/housekeeper.h"

#include <fmt/format.h>

#include "api/flights/trash.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {
namespace {

constexpr std::chrono::minutes kHousekeepingPause{5};

}  // namespace

Housekeeper::Housekeeper(api::Service& service) : service_(service), thread_([this] { Run(); }) {}

Housekeeper::~Housekeeper() {
  {
    const std::lock_guard lock(mutex_);
    is_ended_ = true;
  }
  end_.notify_all();
  thread_.join();
}

void Housekeeper::Run() {
  std::unique_lock lock(mutex_);
  while (!is_ended_) {
    lock.unlock();
    Round();
    lock.lock();
    end_.wait_for(lock, kHousekeepingPause, [this] { return is_ended_; });
  }
}

void Housekeeper::Round() {
  if (!service_.storage_in_place()) return;  // the folder is gone: what is removed now would be another's
  const Result<void> saved = service_.db.SaveAges();
  if (!saved) LogFailure("-", "housekeeping", saved.error().detail);
  const Result<int> expired = service_.spool.RemoveExpired(service_.db.ages().Now());
  if (!expired) LogFailure("-", "housekeeping", expired.error().detail);
  const Result<int> removed = api::RemoveOldTrash(service_);
  if (!removed) LogFailure("-", "trash", removed.error().detail);
  if (removed && *removed > 0)
    LogEvent(fmt::format("{} flights were deleted {} days ago and are removed now", *removed,
                         service_.trash_days));
  service_.db.FillReserve();
}

}  // namespace skyquilt::server
