// StitchSandboxed: one flight from files to finished products, made by a sandboxed process of its own: it
// reads the flight's files, writes below the task's folder, and has no access to the catalogue, other flights
// or the network. This side forwards its progress, watches its limits, and checks that the figures of its
// outcome are possible for a map. Blocking. The process has ended when this returns; its files stay as it
// left them. Errors: those of StitchToDirectory; kUnprocessable (it exceeded its time or memory); kCancelled;
// kInternal and kUnavailable (it died or could not be started; the next attempt may succeed).
#pragma once

#include "core/base/progress.h"
#include "server/jobs/child_messages.h"
#include "server/jobs/job_limits.h"

namespace skyquilt::server {

struct StitchedInSandbox {
  Result<StitchOutcome> outcome;
  bool has_died = false;  // in the middle of its work, of which the next attempt can take over what there is
};

StitchedInSandbox StitchSandboxed(StitchTask task, const JobLimits& limits, Progress& progress);

// What that process does: hears of its task on standard input, confines itself, and tells how it goes on
// standard output. The exit code.
int StitchInSandbox(int parent);

}  // namespace skyquilt::server
