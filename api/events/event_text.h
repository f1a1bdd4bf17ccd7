// What inliers of events are sent, as the HTML standard's text/event-stream has it (9.2.5). Pure; any
// thread.
#pragma once

#include <string>

#include "storage/catalogue/event_log.h"
#include "storage/db/clock.h"
#include "storage/jobs/job_queue.h"

namespace skyquilt::api {

std::string EventText(const storage::Event& event);
// How far a job is. It has no id: nobody who comes back is told what was.
std::string ProgressText(const storage::Job& job, storage::Time now);

}  // namespace skyquilt::api
