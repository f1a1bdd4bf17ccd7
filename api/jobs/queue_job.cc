#include "api/jobs/queue_job.h"

#include "api/auth/flight_access.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "core/base/try.h"

namespace skyquilt::api {

Result<storage::Job> QueueJob(Service& service, const Request& request, const std::string& flight_id,
                              const std::string& body) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(CheckMayChange(service, request, flight_id));
  SKYQUILT_TRY_ASSIGN(const JobRequest wish, ParseJobRequest(body));
  if (wish.priority > 0 && !request.is_admin) {
    return Error{ErrorCode::kForbidden, "A priority above 0 asks for a token of scope admin.", ""};
  }
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  if (flight.file_count == 0) {
    return Error{ErrorCode::kConflict, "This flight has no files yet. Upload photos first.", ""};
  }
  return service.queue.Add(flight_id, wish.options.value_or(flight.options), storage::Now(),
                           {wish.priority, request.owner});
}

}  // namespace skyquilt::api
