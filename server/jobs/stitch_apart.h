// StitchApart: one flight from files to finished products, made by a confined process of its own: it reads
// the flight's files, writes below the task's folder, and knows neither the catalogue nor other flights nor
// the network. This side passes its progress on, watches its limits, and believes no more of its outcome than
// that its figures could be a map's. Blocking. The process is gone when this returns; what it wrote is as it
// left it. Errors: those of StitchToDirectory; kUnprocessable (it took more time or memory than it may have);
// kCancelled; kInternal and kUnavailable (it died, or could not be started; the next attempt may do better).
#pragma once

#include "core/base/progress.h"
#include "server/jobs/job_limits.h"
#include "server/jobs/job_messages.h"

namespace skyquilt::server {

struct StitchedApart {
  Result<StitchOutcome> outcome;
  bool has_died = false;  // in the middle of its work, of which the next attempt can take over what there is
};

StitchedApart StitchApart(StitchTask task, const JobLimits& limits, Progress& progress);

// What that process does: hears of its task on standard input, confines itself, and tells how it goes on
// standard output. The exit code.
int StitchConfined(int parent);

}  // namespace skyquilt::server
