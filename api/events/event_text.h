// The text that subscribers to events are sent, in the format text/event-stream of the HTML standard (9.2.5).
// Pure.
#pragma once

#include <string>

#include "storage/catalogue/event_log.h"
#include "storage/db/clock.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::api {

std::string EventText(const storage::Event& event);
// How far a job is. It has no id: progress is not replayed after a reconnect.
std::string ProgressText(const storage::Job& job, storage::Time now);

}  // namespace skyquilt::api
