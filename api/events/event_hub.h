// EventHub: what all followers of events share, so that a thousand of them ask the database no oftener than
// one. Any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/result.h"
#include "storage/event_log.h"
#include "storage/job_queue.h"

namespace skyquilt::api {

class EventHub {
 public:
  static constexpr int kMostFollowers = 1024;

  EventHub(storage::EventLog& events, storage::JobQueue& queue) : events_(events), queue_(queue) {}

  struct Now {
    std::int64_t latest_seq = 0;
    std::vector<storage::Job> running;
  };
  // At most a quarter of a second old.
  Result<std::shared_ptr<const Now>> Look();

  // False: there are too many followers already.
  bool Join() { return followers_.fetch_add(1) < kMostFollowers || (followers_.fetch_sub(1), false); }
  void Leave() { followers_.fetch_sub(1); }

 private:
  storage::EventLog& events_;
  storage::JobQueue& queue_;
  std::atomic<int> followers_ = 0;
  std::mutex mutex_;
  std::shared_ptr<const Now> now_;
  std::chrono::steady_clock::time_point looked_at_;
};

}  // namespace skyquilt::api
