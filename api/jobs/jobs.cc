#include "api/jobs/jobs.h"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "api/auth/flight_access.h"
#include "api/http/once.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/job_options.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
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
                      service.surfaces.Of(flight.id, *flight.active_revision));
  if (surfaces.empty()) return options;
  stated["heights"] = NameOf(surfaces.back());  // with the ground come the others
  return JsonText(stated);
}

constexpr int kUsualJobsAPage = 200;
constexpr int kMaxJobsAPage = 500;

Result<Response> Queue(Service& service, const Request& request, const std::string& body) {
  SKYQUILT_TRY_ASSIGN(const storage::Job job, QueueJob(service, request, request.Parameter("flight"), body));
  Response response = JsonOf(202, JobJson(job, storage::Now()));
  response.headers.Add("Location", "/api/v1/jobs/" + job.id);
  return response;
}

Result<Response> GetJob(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckId(request.Parameter("job"), "job"));
  SKYQUILT_TRY_ASSIGN(const storage::Job job, service.queue.Get(request.Parameter("job")));
  // Names of machines are for who runs them.
  if (!request.is_admin || job.state != storage::JobState::kRunning)
    return JsonOf(200, JobJson(job, storage::Now()));
  SKYQUILT_TRY_ASSIGN(std::vector<storage::HeldUnit> held, storage::UnitQueue(service.db).Held(job.id));
  SKYQUILT_TRY_ASSIGN(std::vector<storage::WorkerAside> aside, storage::WorkersAside(service.db).List());
  return JsonOf(200, JobJson(job, storage::Now(), WorkersOfJob{std::move(held), std::move(aside)}));
}

Result<Response> ListJobs(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const int limit, PageSizeOf(request, kUsualJobsAPage, kMaxJobsAPage));
  nlohmann::ordered_json list = nlohmann::ordered_json::array(), next_cursor;
  std::optional<std::string> flight;
  if (const auto given = request.Query("flight")) flight = *given;
  if (!request.only_flight.empty()) {
    if (flight && *flight != request.only_flight)
      return JsonOf(200, {{"jobs", list}, {"next_cursor", next_cursor}});
    flight = request.only_flight;
  }
  SKYQUILT_TRY_ASSIGN(const JobPage page, PageOfJobs(service, request, flight, limit));
  if (page.next_cursor) next_cursor = *page.next_cursor;
  for (const storage::Job& job : page.jobs) list.push_back(JobJson(job, storage::Now()));
  return JsonOf(200, {{"jobs", list}, {"next_cursor", next_cursor}});
}

Result<Response> Cancel(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckId(request.Parameter("job"), "job"));
  const Result<storage::Job> job =
      service.db.Free([&] { return service.queue.Cancel(request.Parameter("job"), storage::Now()); });
  if (!job) return job.error();
  return JsonOf(200, JobJson(*job, storage::Now()));
}

// The same again: a new job with the options of one that has ended.
Result<Response> Retry(Service& service, const Request& request) {
  SKYQUILT_TRY(CheckId(request.Parameter("job"), "job"));
  SKYQUILT_TRY_ASSIGN(const storage::Job ended, service.queue.Get(request.Parameter("job")));
  if (!ended.finished) return Error{ErrorCode::kConflict, "This job has not ended yet."};
  const Result<pipeline::MosaicOptions> options = ParseJobOptions(ended.options);
  if (options && options->placing && !options->placing->is_by_lists &&
      ended.state == storage::JobState::kSuccessful) {
    return Error{
        ErrorCode::kConflict,
        "This job has placed the map already; once more it would move it again. Start a job with new "
        "pairs to place it anew."};
  }
  const storage::Time now = storage::Now();
  const int priority = request.is_admin ? ended.priority : std::min(ended.priority, 0);
  SKYQUILT_TRY_ASSIGN(const storage::Job job,
                      service.queue.Add(ended.flight_id, ended.options, now, {priority, request.owner}));
  Response response = JsonOf(202, JobJson(job, now));
  response.headers.Add("Location", "/api/v1/jobs/" + job.id);
  return response;
}

}  // namespace

Result<JobPage> PageOfJobs(Service& service, const Request& request, const std::optional<std::string>& flight,
                           int limit) {
  SKYQUILT_TRY_ASSIGN(const auto cursor, ParseCursor(request.Query("cursor")));
  JobPage page;
  // One more shows whether another page follows.
  SKYQUILT_TRY_ASSIGN(page.jobs, service.queue.List(flight, limit + 1, cursor));
  if (page.jobs.size() > static_cast<std::size_t>(limit)) {
    page.jobs.pop_back();
    page.next_cursor = page.jobs.back().id;
  }
  return page;
}

Result<storage::Job> QueueJob(Service& service, const Request& request, const std::string& flight_id,
                              const std::string& body) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY(CheckMayChange(service, request, flight_id));
  SKYQUILT_TRY_ASSIGN(const JobRequest wish, ParseJobRequest(body));
  if (wish.priority > 0 && !request.is_admin) {
    return Error{ErrorCode::kForbidden, "A priority above 0 asks for a token of scope admin."};
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

void AddJobRoutes(Router& router, Service& service) {
  router.AddBody(
      Method::kPost, "/api/v1/flights/{flight}/jobs",
      [&](const Request& request, const std::string& body) {
        return Once(service, request, body, [&] { return Queue(service, request, body); });
      },
      "Send the options as JSON with its header: curl -H 'Content-Type: application/json' -d '{}' ...");
  router.AddBody(Method::kPost, "/api/v1/jobs/{job}/retry",
                 [&](const Request& request, const std::string& body) {
                   return Once(service, request, body, [&] { return Retry(service, request); });
                 });
  router.Add(Method::kGet, "/api/v1/jobs", On(service, ListJobs));
  router.Add(Method::kGet, "/api/v1/jobs/{job}", On(service, GetJob));
  router.Add(Method::kDelete, "/api/v1/jobs/{job}", On(service, Cancel));
}

}  // namespace skyquilt::api
