// EventHub: one reader that follows the log of events and the progress of running jobs and passes new items
// to all subscribers, so that a thousand subscribers cost the database no more than one. It reads only while
// there are subscribers, in a thread of its own. The latest few thousand items stay in memory; older ones are
// read from the log (EventStream does). Any thread. Errors: the log's.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/event_log.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::api {

// As subscribers are sent it, in the format text/event-stream of the HTML standard (9.2.5).
std::string EventText(const storage::Event& event);

class EventHub {
 public:
  static constexpr std::size_t kMaxListeners = 4096;
  static constexpr std::size_t kUsualMostOfClient = 64;

  struct Item {
    std::int64_t seq = 0;  // of an event; 0: progress
    std::string flight_id;
    std::optional<std::string> job_id;
    std::string text;
  };
  using Items = std::vector<std::shared_ptr<const Item>>;

  EventHub(const storage::EventLog& events, const storage::JobQueue& queue)
      : events_(events), queue_(queue) {}
  ~EventHub() { Stop(); }
  EventHub(const EventHub&) = delete;
  EventHub& operator=(const EventHub&) = delete;

  // Wakes nobody any more once it has come back: before what wakers lead to is destroyed.
  void Stop();

  // Before the first Join. 0: no bound.
  void SetMostOfClient(std::size_t listeners) { max_of_client_ = listeners; }

  enum class Joined { kYes, kFull, kClientFull };
  struct Seat {
    Joined joined = Joined::kYes;
    std::uint64_t id = 0;
  };
  // A listener of this client's; an unnamed client has no bound of its own. Ended by Leave.
  Result<Seat> Join(const std::string& client, const storage::EventFilter& filter);
  void Leave(std::uint64_t id);
  // Called, from the reader's thread, whenever there is something for this listener; must not block.
  void OnNews(std::uint64_t id, std::function<void()> wake);

  // All events up to this one have been read.
  std::int64_t tail() const;
  // Where in memory the events behind `seq` begin, with how far the running jobs are now. Absent: some of
  // them are in the log only.
  struct Place {
    std::uint64_t next = 0;
    Items progress;
  };
  std::optional<Place> Enter(std::int64_t seq) const;
  // What came since, and moves `next` behind it. Absent: the place is no longer in memory.
  Result<std::optional<Items>> Since(std::uint64_t& next) const;

  static bool Matches(const Item& item, const storage::EventFilter& filter);

 private:
  struct Listener {
    std::string client;
    storage::EventFilter filter;
    std::function<void()> wake;
  };
  void Run();
  Result<Items> ReadNew(std::int64_t tail);
  void Append(const Items& items);

  const storage::EventLog& events_;
  const storage::JobQueue& queue_;
  std::size_t max_of_client_ = kUsualMostOfClient;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::thread reader_;
  bool is_ending_ = false;
  std::map<std::uint64_t, Listener> listeners_;
  std::map<std::string, std::size_t> of_client_;
  std::uint64_t next_id_ = 1;

  std::deque<std::shared_ptr<const Item>> items_;
  std::uint64_t first_ = 0;      // place of items_.front()
  std::int64_t seq_before_ = 0;  // events behind this one are in items_, as far as the tail
  std::int64_t tail_ = 0;
  std::map<std::string, std::shared_ptr<const Item>> progress_;  // of running jobs, by job
  bool begins_anew_ = false;                                     // nobody listened for a while
  std::optional<Error> failure_;                                 // of the latest look

  // The reader's own.
  std::map<std::string, std::pair<double, std::string>> sent_progress_;
};

}  // namespace skyquilt::api
