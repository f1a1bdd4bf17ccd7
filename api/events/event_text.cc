#include "api/events/event_text.h"

#include <fmt/format.h>

#include "api/json/json_codec.h"

namespace skyquilt::api {

std::string EventText(const storage::Event& event) {
  return fmt::format("id: {}\nevent: {}\ndata: {}\n\n", event.seq, event.kind,
                     JsonObject({{"at", JsonString(FormatTime(event.at))},
                                 {"flight_id", JsonString(event.flight_id)},
                                 {"job_id", event.job_id ? JsonString(*event.job_id) : std::string("null")},
                                 {event.kind == "deleted" ? "deleted" : event.kind, event.body}}));
}

std::string ProgressText(const storage::Job& job, storage::Time now) {
  return fmt::format("event: progress\ndata: {}\n\n", JobJson(job, now));
}

}  // namespace skyquilt::api
