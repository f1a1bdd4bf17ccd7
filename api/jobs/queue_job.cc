#include "api/jobs/queue_job.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "api/auth/flight_access.h"
#include "api/http/responses.h"
#include "api/json/job_options.h"
#include "api/json/json_codec.h"
#include "api/surface/map_surface.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::api {
namespace {

// A map of others that is to become the flight's has to be there.
Result<void> CheckImported(Service& service, const std::string& flight_id, const std::string& options) {
  SKYQUILT_TRY_ASSIGN(const pipeline::MosaicOptions parsed, ParseJobOptions(options));
  if (parsed.import_file.empty()) return {};
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files, service.catalogue.ListFiles(flight_id));
  const bool is_there = std::any_of(files.begin(), files.end(), [&](const storage::StoredFile& file) {
    return file.name == parsed.import_file;
  });
  if (is_there) return {};
  return flight::Because(ErrorCode::kConflict,
                         {flight::RemarkCode::kFailImportMissing, {{"file", parsed.import_file}}});
}

// A map that is only moved keeps its heights, which have to be made anew: the job's options say so.
Result<std::string> KeepHeights(Service& service, const storage::Flight& flight, std::string options) {
  SKYQUILT_TRY_ASSIGN(const pipeline::MosaicOptions parsed, ParseJobOptions(options));
  if (!parsed.placing || !flight.active_revision) return options;
  nlohmann::json stated = ParseJson(options);
  if (stated.contains("heights")) return options;
  SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces,
                      SurfacesOf(service, flight.id, *flight.active_revision));
  if (surfaces.empty()) return options;
  stated["heights"] = NameOf(surfaces.back());  // with the ground come the others
  return JsonText(stated);
}

}  // namespace

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
    return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kFailNoFilesYet);
  }
  SKYQUILT_TRY_ASSIGN(const std::string options,
                      KeepHeights(service, flight, wish.options.value_or(flight.options)));
  SKYQUILT_TRY(CheckImported(service, flight_id, options));
  return service.queue.Add(flight_id, options, storage::Now(), {wish.priority, request.owner});
}

}  // namespace skyquilt::api
