// Events as they happen, by Server-Sent Events (the HTML standard, 9.2): GET /api/v1/events, of all flights,
// one flight or one job. Every event has its number as its id: a client that comes back with Last-Event-ID
// gets what it missed. Between them, progress of running jobs, which is not replayed.

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "api/auth/access.h"
#include "api/events/event_hub.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMaxAtOnce = 200;
constexpr std::chrono::seconds kPing{15};  // proxies close what is silent

// One listener: first what it missed, from the log, then what the hub hands on.
class EventStream final : public LiveSource {
 public:
  EventStream(Service& service, const Request& request, std::uint64_t seat, storage::EventFilter filter,
              std::int64_t after)
      : service_(service), owner_(request.owner), seat_(seat), filter_(std::move(filter)), after_(after) {}
  ~EventStream() override { service_.event_hub.Leave(seat_); }

  void OnNews(std::function<void()> wake) override { service_.event_hub.OnNews(seat_, std::move(wake)); }
  bool WaitsForDisk() const override { return !next_; }

  Result<std::string> Next() override {
    if (!IsStillGood(service_, owner_)) {
      return Error{ErrorCode::kUnauthorized, "The token of this stream was revoked or has ended."};
    }
    std::string text;
    if (is_first_) text = "retry: 2000\n\n";
    is_first_ = false;
    SKYQUILT_TRY(next_ ? HandOn(text) : CatchUp(text));
    if (!text.empty()) spoke_at_ = Clock::now();
    if (text.empty() && Clock::now() - spoke_at_ >= kPing) {
      text = ": still here\n\n";
      spoke_at_ = Clock::now();
    }
    return text;
  }

 private:
  Result<void> HandOn(std::string& text) {
    SKYQUILT_TRY_ASSIGN(const auto items, service_.event_hub.Since(*next_));
    if (!items) {
      next_.reset();  // too slow: the rest is in the log
      return {};
    }
    for (const auto& item : *items) {
      if (EventHub::Matches(*item, filter_)) text += item->text;
      if (item->seq > 0) after_ = item->seq;
    }
    return {};
  }

  Result<void> CatchUp(std::string& text) {
    // Before reading: events that arrive meanwhile must not count as read.
    const std::int64_t tail = service_.event_hub.tail();
    SKYQUILT_TRY_ASSIGN(const std::vector<storage::Event> events,
                        service_.events.After(after_, filter_, kMaxAtOnce));
    for (const storage::Event& event : events) {
      text += EventText(event);
      after_ = event.seq;
    }
    if (events.size() == kMaxAtOnce) return {};
    after_ = std::max(after_, tail);
    const auto place = service_.event_hub.Enter(after_);
    if (!place) return {};
    next_ = place->next;
    for (const auto& item : place->progress) {
      if (EventHub::Matches(*item, filter_)) text += item->text;
    }
    return {};
  }

  Service& service_;
  const std::string owner_;
  std::uint64_t seat_;
  storage::EventFilter filter_;
  std::int64_t after_;                 // the last event that was sent or skipped
  std::optional<std::uint64_t> next_;  // where in the hub it goes on; absent: from the log
  bool is_first_ = true;
  Clock::time_point spoke_at_ = Clock::now();
};

std::optional<std::int64_t> SeqFrom(std::string_view text) {
  const auto seq = ParseNumber<std::int64_t>(text);
  return seq && *seq >= 0 ? seq : std::nullopt;
}

Error NothingToFollow() {
  return {ErrorCode::kNotFound, "This token opens one flight, and this is none of its events."};
}

Result<Response> Follow(Service& service, const Request& request) {
  storage::EventFilter filter;
  if (const auto flight = request.Query("flight")) filter.flight_id = *flight;
  if (const auto job = request.Query("job")) filter.job_id = *job;
  for (const auto& id : {filter.flight_id, filter.job_id}) {
    if (!id || storage::IsId(*id)) continue;
    return Error{ErrorCode::kInvalidArgument, "\"flight\" and \"job\" are ids as the server gave them."};
  }
  if (!request.only_flight.empty()) {
    if (filter.flight_id.value_or(request.only_flight) != request.only_flight) return NothingToFollow();
    filter.flight_id = request.only_flight;
    if (filter.job_id) {
      const Result<storage::Job> job = service.queue.Get(*filter.job_id);
      if (!job || job->flight_id != request.only_flight) return NothingToFollow();
    }
  }
  // A browser sends the header when it comes back; the parameter is for whoever knows where to begin.
  std::string_view from = request.headers.Find("Last-Event-ID");
  if (from.empty()) from = request.Query("after").value_or("");
  std::optional<std::int64_t> after = SeqFrom(from);
  if (!from.empty() && !after) {
    return Error{ErrorCode::kInvalidArgument, "Last-Event-ID is the number of an event."};
  }
  if (!after) {
    SKYQUILT_TRY_ASSIGN(const std::int64_t latest, service.events.Latest());
    after = latest;
  }
  SKYQUILT_TRY_ASSIGN(const EventHub::Seat seat, service.event_hub.Join(request.client, filter));
  if (seat.joined == EventHub::Joined::kFull) {
    return Error{ErrorCode::kUnavailable, "Too many are following events. Try again later."};
  }
  if (seat.joined == EventHub::Joined::kClientFull) {
    return Error{ErrorCode::kRateLimited,
                 "As many as may are following events from your address already. Close some of them."};
  }
  Response response;
  response.headers.Add("Content-Type", "text/event-stream");
  response.headers.Add("Cache-Control", "no-store");
  response.headers.Add("X-Accel-Buffering", "no");
  response.live = std::make_unique<EventStream>(service, request, seat.id, std::move(filter), *after);
  return response;
}

Result<Response> Log(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckId(request.Parameter("job"), "job"));
  SKYQUILT_TRY_ASSIGN(const storage::Job job, service.queue.Get(request.Parameter("job")));
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::Event> events, service.events.OfJob(job.id));
  nlohmann::ordered_json items = nlohmann::ordered_json::array();
  for (const storage::Event& event : events) {
    items.push_back(
        {{"seq", event.seq}, {"at", FormatTime(event.at)}, {"job", ParseOrderedJson(event.body)}});
  }
  return JsonOf(200, {{"events", items}});
}

}  // namespace

void AddEventRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/events", On(service, Follow));
  router.Add(Method::kGet, "/api/v1/jobs/{job}/log", On(service, Log));
}

}  // namespace skyquilt::api
