// Flights, files and jobs as the JSON of the API, and the JSON that clients send as checked values. Pure.
// Errors: kInvalidArgument (not JSON, nested too deep), kUnprocessable (a field that is unknown or of a wrong
// kind).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/previews.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/unit_queue.h"
#include "storage/jobs/workers_aside.h"

namespace skyquilt::api {

// What stands in an address for a revision where the preview is meant, and nothing but it.
inline constexpr std::string_view kPreviewRevision = "preview";

inline constexpr std::size_t kMaxFlightNameBytes = 200;

// Everything the API says of one flight.
struct FlightView {
  storage::Flight flight;
  std::optional<storage::Job> job;            // the latest
  std::optional<storage::Revision> revision;  // what is shown
  std::optional<storage::Preview> preview;    // until then
  std::string base_path = {};                 // before paths of this server (Request::base_path)
  bool may_change = true;                     // may who asks (api/auth/flight_access)?
};

// One file of an upload: stored under `name`, or refused with `error`; `note` says when the name was changed.
struct FileOutcome {
  std::string name;
  std::int64_t bytes = 0;
  std::string note;
  std::optional<Error> error;
};

// What nothing places is drawn around latitude 0, longitude 0: a place in the sea.
bool LiesSomewhere(const geo::LatLonBounds& bounds);

nlohmann::ordered_json FlightJson(const FlightView& view, storage::Time now);
// Which worker has which part of a job, and which take nothing because their machines are in trouble.
struct WorkersOfJob {
  std::vector<storage::HeldUnit> held;
  std::vector<storage::WorkerAside> aside;
};
// `workers`: for whoever may know; absent: nobody asked.
nlohmann::ordered_json JobJson(const storage::Job& job, storage::Time now,
                               const std::optional<WorkersOfJob>& workers = std::nullopt);
nlohmann::ordered_json FileJson(const storage::StoredFile& file);
nlohmann::ordered_json FileOutcomesJson(const std::vector<FileOutcome>& files);

// "2026-11-21T04:55:03.123Z"
std::string FormatTime(storage::Time time);

// The bodies of POST and PATCH /flights, checked; options as compact JSON text. An empty body counts as {}.
Result<storage::FlightChange> ParseFlightFields(std::string_view body);
// The body of POST /flights/{id}/jobs: {"options":{...},"priority":0}.
struct JobRequest {
  std::optional<std::string> options;  // checked, as compact JSON text; absent: the flight's
  int priority = 0;
};
Result<JobRequest> ParseJobRequest(std::string_view body);

}  // namespace skyquilt::api
