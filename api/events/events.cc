#include "api/events/events.h"

#include <fmt/format.h>

#include <charconv>
#include <map>

#include "api/json_codec.h"
#include "api/problem.h"
#include "api/responses.h"
#include "storage/ids.h"

namespace skyquilt::api {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMostAtOnce = 200;
constexpr std::chrono::seconds kPing{15};  // proxies close what is silent

class EventStream final : public LiveSource {
 public:
  EventStream(Service& service, storage::EventFilter filter, std::int64_t after)
      : service_(service), filter_(std::move(filter)), after_(after) {}
  ~EventStream() override { service_.event_hub.Leave(); }

  Result<std::string> Next() override {
    std::string text;
    if (is_first_) text = "retry: 2000\n\n";
    is_first_ = false;
    const auto now = service_.event_hub.Look();
    if (!now) return now.error();
    if ((*now)->latest_seq > after_) {
      const Result<std::vector<storage::Event>> events = service_.events.After(after_, filter_, kMostAtOnce);
      if (!events) return events.error();
      for (const storage::Event& event : *events) text += Told(event);
      // A full answer may not be the last; else all up to the latest has been looked through.
      const bool is_full = events->size() == kMostAtOnce;
      after_ = is_full ? events->back().seq : std::max(after_, (*now)->latest_seq);
      if (!events->empty()) after_ = std::max(after_, events->back().seq);
    }
    for (const storage::Job& job : (*now)->running) text += Progress(job);
    if (!text.empty()) spoke_at_ = Clock::now();
    if (text.empty() && Clock::now() - spoke_at_ >= kPing) {
      text = ": still here\n\n";
      spoke_at_ = Clock::now();
    }
    return text;
  }

 private:
  static std::string Told(const storage::Event& event) {
    return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", event.seq, event.kind,
                       JsonObject({{"at", JsonString(FormatTime(event.at))},
                                   {"flight_id", JsonString(event.flight_id)},
                                   {"job_id", event.job_id ? JsonString(*event.job_id) : std::string("null")},
                                   {event.kind == "deleted" ? "deleted" : event.kind, event.body}}));
  }

  std::string Progress(const storage::Job& job) {
    if (filter_.job_id && job.id != *filter_.job_id) return "";
    if (filter_.flight_id && job.flight_id != *filter_.flight_id) return "";
    std::string told = JobJson(job, storage::Now());
    auto& [progress, message] = last_[job.id];
    if (progress == job.progress && message == job.message) return "";
    progress = job.progress;
    message = job.message;
    return fmt::format("event: progress\ndata: {}\n\n", told);
  }

  Service& service_;
  storage::EventFilter filter_;
  std::int64_t after_;
  bool is_first_ = true;
  Clock::time_point spoke_at_ = Clock::now();
  std::map<std::string, std::pair<double, std::string>> last_;
};

std::optional<std::int64_t> SeqFrom(std::string_view text) {
  std::int64_t seq = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), seq);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || seq < 0) {
    return std::nullopt;
  }
  return seq;
}

Response Follow(Service& service, const Request& request) {
  storage::EventFilter filter;
  if (const auto flight = request.Query("flight")) filter.flight_id = *flight;
  if (const auto job = request.Query("job")) filter.job_id = *job;
  for (const auto& id : {filter.flight_id, filter.job_id}) {
    if (!id || storage::IsId(*id)) continue;
    return Problem(
        {ErrorCode::kInvalidArgument, "\"flight\" and \"job\" are ids as the server gave them.", ""},
        request);
  }
  // A browser sends the header when it comes back; the parameter is for whoever knows where to begin.
  std::string_view from = request.headers.Find("Last-Event-ID");
  if (from.empty()) from = request.Query("after").value_or("");
  std::optional<std::int64_t> after = SeqFrom(from);
  if (!from.empty() && !after) {
    return Problem({ErrorCode::kInvalidArgument, "Last-Event-ID is the number of an event.", ""}, request);
  }
  if (!after) {
    const Result<std::int64_t> latest = service.events.Latest();
    if (!latest) return Problem(latest.error(), request);
    after = *latest;
  }
  if (!service.event_hub.Join()) {
    return Problem({ErrorCode::kUnavailable, "Too many are following events. Try again later.", ""}, request);
  }
  Response response;
  response.headers.Add("Content-Type", "text/event-stream");
  response.headers.Add("Cache-Control", "no-store");
  response.headers.Add("X-Accel-Buffering", "no");
  response.live = std::make_unique<EventStream>(service, std::move(filter), *after);
  return response;
}

Response Log(Service& service, const Request& request) {
  const Result<void> checked = CheckId(request.Parameter("job"), "job");
  if (!checked) return Problem(checked.error(), request);
  const Result<storage::Job> job = service.queue.Get(request.Parameter("job"));
  if (!job) return Problem(job.error(), request);
  storage::EventFilter filter;
  filter.job_id = job->id;
  constexpr int kMostLines = 1000;
  const Result<std::vector<storage::Event>> events = service.events.After(0, filter, kMostLines);
  if (!events) return Problem(events.error(), request);
  std::vector<std::string> items;
  for (const storage::Event& event : *events) {
    items.push_back(JsonObject(
        {{"seq", std::to_string(event.seq)}, {"at", JsonString(FormatTime(event.at))}, {"job", event.body}}));
  }
  return Json(200, JsonObject({{"events", JsonArray(items)}}));
}

}  // namespace

void AddEventRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/events", [&](const Request& r) { return Follow(service, r); });
  router.Add(Method::kGet, "/api/v1/jobs/{job}/log", [&](const Request& r) { return Log(service, r); });
}

}  // namespace skyquilt::api
