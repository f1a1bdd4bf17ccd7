#include "api/events/event_hub.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "api/json/json_codec.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {

std::string EventText(const storage::Event& event) {
  const nlohmann::ordered_json data = {
      {"at", FormatTime(event.at)},
      {"flight_id", event.flight_id},
      {"job_id", event.job_id ? nlohmann::ordered_json(*event.job_id) : nlohmann::ordered_json()},
      {event.kind, ParseOrderedJson(event.body)}};
  return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", event.seq, event.kind, JsonText(data));
}

namespace {

// How far a job is. It has no id: progress is not replayed after a reconnect.
std::string ProgressText(const storage::Job& job, storage::Time now) {
  return fmt::format("event: progress\ndata: {}\n\n", JsonText(JobJson(job, now)));
}

constexpr std::chrono::milliseconds kReadInterval{200};
constexpr std::size_t kMaxItems = 4096;
constexpr int kMaxReadAtOnce = 500;

}  // namespace

void EventHub::Stop() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    changed_.notify_all();
  }
  if (reader_.joinable()) reader_.join();
}

Result<EventHub::Seat> EventHub::Join(const std::string& client, const storage::EventFilter& filter) {
  // Asked before the lock: who joins while nobody listens begins with what is new from now on.
  SKYQUILT_TRY_ASSIGN(const std::int64_t latest, events_.Latest());
  const std::lock_guard lock(mutex_);
  if (listeners_.size() >= kMaxListeners) return Seat{Joined::kFull, 0};
  if (!client.empty()) {
    std::size_t& held = of_client_[client];
    if (max_of_client_ > 0 && held >= max_of_client_) return Seat{Joined::kClientFull, 0};
    ++held;
  }
  if (listeners_.empty()) {
    first_ += items_.size();
    items_.clear();
    progress_.clear();
    begins_anew_ = true;
    seq_before_ = tail_ = std::max(tail_, latest);
  }
  const std::uint64_t id = next_id_++;
  listeners_[id] = {client, filter, nullptr};
  if (!reader_.joinable() && !is_ending_) reader_ = std::thread([this] { Run(); });
  changed_.notify_all();
  return Seat{Joined::kYes, id};
}

void EventHub::Leave(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto listener = listeners_.find(id);
  const auto held = of_client_.find(listener->second.client);
  if (held != of_client_.end() && --held->second == 0) of_client_.erase(held);
  listeners_.erase(listener);
}

void EventHub::OnNews(std::uint64_t id, std::function<void()> wake) {
  const std::lock_guard lock(mutex_);
  listeners_.at(id).wake = std::move(wake);
}

std::int64_t EventHub::tail() const {
  const std::lock_guard lock(mutex_);
  return tail_;
}

std::optional<EventHub::Place> EventHub::Enter(std::int64_t seq) const {
  const std::lock_guard lock(mutex_);
  if (seq < seq_before_) return std::nullopt;
  Place place{first_ + items_.size(), {}};
  // Back to the first item behind `seq`; progress between them comes along.
  for (std::size_t i = items_.size(); i > 0 && (items_[i - 1]->seq == 0 || items_[i - 1]->seq > seq); --i) {
    if (items_[i - 1]->seq > seq) place.next = first_ + i - 1;
  }
  for (const auto& [job, item] : progress_) place.progress.push_back(item);
  return place;
}

Result<std::optional<EventHub::Items>> EventHub::Since(std::uint64_t& next) const {
  const std::lock_guard lock(mutex_);
  if (failure_) return *failure_;
  if (next < first_) return std::optional<Items>();
  Items items(items_.begin() + static_cast<std::ptrdiff_t>(next - first_), items_.end());
  next = first_ + items_.size();
  return std::optional<Items>(std::move(items));
}

bool EventHub::Matches(const Item& item, const storage::EventFilter& filter) {
  if (filter.job_id) return item.job_id == filter.job_id;
  return !filter.flight_id || item.flight_id == *filter.flight_id;
}

void EventHub::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return is_ending_ || !listeners_.empty(); });
    if (is_ending_) return;
    const std::int64_t tail = tail_;
    if (std::exchange(begins_anew_, false)) sent_progress_.clear();
    lock.unlock();
    const Result<Items> found = ReadNew(tail);
    lock.lock();
    failure_ = found ? std::nullopt : std::optional<Error>(found.error());
    // Who joined meanwhile, as the first again, may have moved the tail on: what was read is then in the log.
    if (found && tail == tail_) Append(*found);
    if (failure_) {
      for (const auto& [id, listener] : listeners_) {
        if (listener.wake) listener.wake();
      }
    }
    changed_.wait_for(lock, kReadInterval, [&] { return is_ending_; });
  }
}

Result<EventHub::Items> EventHub::ReadNew(std::int64_t tail) {
  Items items;
  for (bool is_full = true; is_full;) {
    SKYQUILT_TRY_ASSIGN(const std::vector<storage::Event> events, events_.After(tail, {}, kMaxReadAtOnce));
    for (const storage::Event& event : events) {
      items.push_back(
          std::make_shared<const Item>(Item{event.seq, event.flight_id, event.job_id, EventText(event)}));
      tail = event.seq;
    }
    is_full = events.size() == kMaxReadAtOnce;
  }
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::Job> running, queue_.ListRunning());
  std::map<std::string, std::pair<double, std::string>> sent_progress;
  for (const storage::Job& job : running) {
    auto now = std::pair(job.progress, job.message);
    const auto before = sent_progress_.find(job.id);
    if (before == sent_progress_.end() || before->second != now) {
      items.push_back(
          std::make_shared<const Item>(Item{0, job.flight_id, job.id, ProgressText(job, storage::Now())}));
    }
    sent_progress[job.id] = std::move(now);
  }
  sent_progress_ = std::move(sent_progress);
  return items;
}

void EventHub::Append(const Items& items) {
  for (const auto& item : items) {
    if (item->seq > 0) tail_ = item->seq;
    if (item->seq == 0) progress_[*item->job_id] = item;
    items_.push_back(item);
  }
  std::erase_if(progress_, [&](const auto& entry) { return !sent_progress_.contains(entry.first); });
  while (items_.size() > kMaxItems) {
    if (items_.front()->seq > 0) seq_before_ = items_.front()->seq;
    items_.pop_front();
    ++first_;
  }
  for (const auto& [id, listener] : listeners_) {
    if (!listener.wake) continue;
    for (const auto& item : items) {
      if (!Matches(*item, listener.filter)) continue;
      listener.wake();
      break;
    }
  }
}

}  // namespace skyquilt::api
