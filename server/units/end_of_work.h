// How a worker tells the queue of an end, and whether another attempt may do better. Any thread.
#pragma once

#include <chrono>
#include <string>
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

// Whether work is given back for such a trouble. A job that meets it on a worker again and again brings it
// along: from then on it costs attempts, so that it ends with its reason and the queue goes on.
inline bool IsGivenBack(WorkerContext& context, const std::string& job_id, const Error& failure) {
  constexpr int kFreeForAJob = 3;
  constexpr std::size_t kMaxJobs = 1'000;
  if (!context.is_shared || !IsOfMachine(failure.code)) return false;
  context.fault = failure;
  if (context.given_back.size() >= kMaxJobs) context.given_back.clear();
  return ++context.given_back[job_id] <= kFreeForAJob;
}

// The end of a job must reach the queue, even when the database is busy or the disk was full a moment ago.
template <typename Tell>
void TellUntilHeard(std::string_view job_id, Tell tell) {
  constexpr int kTries = 5;
  for (int attempt = 1; attempt <= kTries; ++attempt) {
    const Result<bool> written = tell();
    if (written) return;
    LogFailure(job_id, "queue", written.error().detail);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  // Not heard: the lease runs out, and the queue hands the work to the next attempt.
}

}  // namespace skyquilt::server
