// Jobs: queue the stitching of a flight, watch it, cancel it. States are those of OGC API Processes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

// Queues a stitching job for a flight, for every API that offers it; `body`: that of POST
// /api/v1/flights/{flight}/jobs. Errors: kNotFound (no such
// flight), kConflict (it has no files, or an unfinished job), kForbidden (another owner's), kUnprocessable
// and kInvalidArgument (the request), and the queue's.
Result<storage::Job> QueueJob(Service& service, const Request& request, const std::string& flight_id,
                              const std::string& body);

struct JobPage {
  std::vector<storage::Job> jobs;
  std::optional<std::string> next_cursor;
};
// Newest first, of one flight where one is named, from the request's "cursor" on. Errors: kInvalidArgument,
// and the queue's.
Result<JobPage> PageOfJobs(Service& service, const Request& request, const std::optional<std::string>& flight,
                           int limit);

}  // namespace skyquilt::api
