// How a worker tells the queue of an end, and whether another attempt may do better. Any thread.
#pragma once

#include <chrono>
#include <string_view>
#include <thread>

#include "core/base/result.h"
#include "server/jobs/worker_context.h"
#include "server/routing/request_log.h"

namespace skyquilt::server {

// Trouble of the machine may pass; trouble with the input will not.
inline bool MayRetry(ErrorCode code) {
  return code == ErrorCode::kIo || code == ErrorCode::kUnavailable || code == ErrorCode::kInternal ||
         code == ErrorCode::kTimeout;
}

// Trouble that another machine may not have: its disk, its network, its store. What is given back for it
// costs no attempt where other machines work on the same queue; on one alone it is the job's, which says what
// to do.
inline bool IsOfMachine(ErrorCode code) {
  return code == ErrorCode::kIo || code == ErrorCode::kUnavailable || code == ErrorCode::kOutOfSpace;
}

// A machine's trouble that costs an attempt leaves another to the others, also a full disk.
inline bool MayRetry(const WorkerContext& context, ErrorCode code) {
  return MayRetry(code) || (context.is_shared && IsOfMachine(code));
}

// Whether work is given back for such a trouble. What meets it again and again, counted in the catalogue over
// all workers and their lives, brings it along: from then on it costs attempts, so that it ends with its
// reason and the queue goes on. `held`: the lease, of a job or a unit, and `queue` its queue.
template <typename Queue, typename Held>
bool IsGivenBack(WorkerContext& context, Queue& queue, const Held& held, const Error& failure) {
  if (!context.is_shared || !IsOfMachine(failure.code)) return false;
  context.fault = failure;
  const Result<int> troubles = queue.CountTrouble(held);
  return !troubles || *troubles <= storage::kFreeTroubles;  // where nobody counts, that is trouble as well
}

// The end of a job must reach the queue, even when the database is busy or the disk was full a moment ago.
template <typename Tell>
void TellUntilHeard(WorkerContext& context, std::string_view job_id, Tell tell) {
  constexpr int kTries = 5;
  for (int attempt = 1; attempt <= kTries; ++attempt) {
    const Result<bool> written = tell();
    if (written) return;
    LogFailure(job_id, "queue", written.error());
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  // Not heard: where machines share the queue, the worker gives it back once it is. Else the lease runs out,
  // and the queue hands the work to the next attempt.
  context.may_hold = context.is_shared;
}

}  // namespace skyquilt::server
