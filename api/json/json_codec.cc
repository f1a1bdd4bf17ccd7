#include "api/json/json_codec.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/json/job_options.h"
#include "api/json/json_text.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_json.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::api {
namespace {

using nlohmann::ordered_json;

ordered_json TimeOrNull(const std::optional<storage::Time>& time) {
  return time ? ordered_json(FormatTime(*time)) : ordered_json(nullptr);
}

struct Eta {
  double left_s = 0.0;
  double low_s = 0.0;
  double high_s = 0.0;
};

// What jobs before took and what the pace of this attempt says, the more of the latter the further it is.
// Nothing where there is neither.
std::optional<Eta> EtaOf(const storage::Job& job, storage::Time now) {
  constexpr double kMinProgress = 0.03;
  constexpr double kPaceLow = 0.8, kPaceHigh = 1.25;   // of a pace that others confirm
  constexpr double kAloneLow = 0.5, kAloneHigh = 2.0;  // of one that nothing confirms
  if (job.state != storage::JobState::kRunning || !job.attempt_started) return std::nullopt;
  const double done = std::clamp(job.progress, 0.0, 1.0);
  const bool has_pace = done >= kMinProgress;
  if (!has_pace && !job.expected) return std::nullopt;
  const double elapsed_s = std::max(0.0, std::chrono::duration<double>(now - *job.attempt_started).count());
  const double pace_s = has_pace ? elapsed_s / done : 0.0;
  if (!job.expected) {
    const double left_s = pace_s * (1.0 - done);
    return Eta{left_s, left_s * kAloneLow, left_s * kAloneHigh};
  }
  const double trust = has_pace ? done : 0.0;  // in the pace
  const auto left = [&](double expected_s, double of_pace) {
    return (1.0 - done) * ((1.0 - trust) * expected_s + trust * of_pace * pace_s);
  };
  return Eta{left(job.expected->total_s, 1.0), left(job.expected->low_s, kPaceLow),
             left(job.expected->high_s, kPaceHigh)};
}

ordered_json ErrorOf(const storage::Job& job) {
  // A job that waits for another attempt keeps the last error for the log; it has not failed.
  if (job.state != storage::JobState::kFailed || !job.error) return nullptr;
  return {{"code", job.error->code},
          {"message", job.error->message},
          {"reason", flight::ReasonValue<ordered_json>(job.error->reason)}};
}

const char* FlightState(const FlightView& view) {
  using storage::JobState;
  if (view.job && view.job->state == JobState::kAccepted) return "queued";
  if (view.job && view.job->state == JobState::kRunning) return "processing";
  if (view.revision) return "ready";  // an older map stays up when a later job fails; `error` says so
  if (view.job && view.job->state == JobState::kFailed) return "failed";
  return view.flight.file_count > 0 ? "uploaded" : "empty";
}

Result<ordered_json> ParseObject(std::string_view body) {
  if (body.find_first_not_of(" \t\r\n") == std::string_view::npos) return ordered_json::object();
  SKYQUILT_TRY(CheckJsonText(body));
  ordered_json parsed = ParseOrderedJson(body);
  if (parsed.is_discarded()) return Error{ErrorCode::kInvalidArgument, "The body is not JSON."};
  if (!parsed.is_object()) return Error{ErrorCode::kUnprocessable, "The body must be a JSON object."};
  return parsed;
}

Error UnknownField(const std::string& field) {
  return {ErrorCode::kUnprocessable, fmt::format("The field \"{}\" is not known.", field)};
}

Result<std::string> CheckedName(const ordered_json& value) {
  if (!value.is_string()) return Error{ErrorCode::kUnprocessable, "The field \"name\" must be a text."};
  const auto name = value.get<std::string>();
  if (name.empty() || name.size() > kMaxFlightNameBytes) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("The field \"name\" must be 1 to {} bytes long.", kMaxFlightNameBytes)};
  }
  return name;
}

Result<std::string> CheckedOptions(const ordered_json& value) {
  std::string text = JsonText(value);
  const Result<pipeline::MosaicOptions> options = ParseJobOptions(text);
  if (!options) return options.error();
  return text;
}

Result<std::string> CheckedFlightOptions(const ordered_json& value) {
  if (value.is_object() && value.contains("place")) {
    return Error{ErrorCode::kUnprocessable,
                 "The option \"place\" moves the map that there is, once: give it to a job "
                 "(POST /api/v1/flights/{flight}/jobs), not to the flight."};
  }
  return CheckedOptions(value);
}

Result<std::vector<std::string>> CheckedTagList(const ordered_json& value) {
  if (!value.is_array() ||
      !std::all_of(value.begin(), value.end(), [](const ordered_json& tag) { return tag.is_string(); })) {
    return Error{ErrorCode::kUnprocessable, "The field \"tags\" must be a list of texts."};
  }
  return storage::CheckedTags(value.get<std::vector<std::string>>());
}

Result<int> CheckedPriority(const ordered_json& value) {
  constexpr int kMaxPriority = storage::kMaxPriority;
  if (!value.is_number_integer() || value < -kMaxPriority || value > kMaxPriority) {
    return Error{ErrorCode::kUnprocessable,
                 fmt::format("The field \"priority\" must be a whole number from {} to {}.", -kMaxPriority,
                             kMaxPriority)};
  }
  return value.get<int>();
}

}  // namespace

bool LiesSomewhere(const geo::LatLonBounds& bounds) {
  constexpr double kAroundZeroDeg = 0.1;
  const std::array<double, 4> sides = bounds.ToArray();
  return std::any_of(sides.begin(), sides.end(), [](double deg) { return std::abs(deg) >= kAroundZeroDeg; });
}

std::string FormatTime(storage::Time time) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(time);
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time - seconds).count();
  const std::time_t whole = std::chrono::system_clock::to_time_t(seconds);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(whole), ms);
}

ordered_json JobJson(const storage::Job& job, storage::Time now, const std::optional<WorkersOfJob>& workers) {
  ordered_json value;
  value["id"] = job.id;
  value["flight_id"] = job.flight_id;
  value["state"] = storage::JobStateName(job.state);
  value["stage"] = job.stage;
  value["progress"] = job.progress;
  value["message"] = job.message;
  const std::optional<Eta> eta = EtaOf(job, now);
  value["eta_s"] = eta ? ordered_json(eta->left_s) : ordered_json(nullptr);
  value["eta_low_s"] = eta ? ordered_json(eta->low_s) : ordered_json(nullptr);
  value["eta_high_s"] = eta ? ordered_json(eta->high_s) : ordered_json(nullptr);
  value["priority"] = job.priority;
  value["options"] = ParseOrderedJson(job.options.empty() ? "{}" : job.options);
  value["attempts"] = job.attempts;
  value["created_at"] = FormatTime(job.created);
  value["started_at"] = TimeOrNull(job.started);
  value["finished_at"] = TimeOrNull(job.finished);
  value["error"] = ErrorOf(job);
  if (!workers) return value;
  value["parts"] = ordered_json::array();
  for (const storage::HeldUnit& unit : workers->held) {
    value["parts"].push_back({{"kind", unit.kind},
                              {"part", unit.number + 1},
                              {"worker", unit.worker},
                              {"since", FormatTime(unit.since)},
                              {"attempt", unit.attempt}});
  }
  value["workers_aside"] = ordered_json::array();
  for (const storage::WorkerAside& worker : workers->aside) {
    value["workers_aside"].push_back({{"worker", worker.worker},
                                      {"since", FormatTime(worker.since)},
                                      {"until", FormatTime(worker.until)},
                                      {"times", worker.times},
                                      {"code", worker.code},
                                      {"message", worker.message}});
  }
  return value;
}

ordered_json FlightJson(const FlightView& view, storage::Time now) {
  ordered_json value;
  value["id"] = view.flight.id;
  value["name"] = view.flight.name;
  value["state"] = FlightState(view);
  value["created_at"] = FormatTime(view.flight.created);
  value["file_count"] = view.flight.file_count;
  value["bytes"] = view.flight.bytes;
  value["options"] = ParseOrderedJson(view.flight.options);
  value["tags"] = view.flight.tags;
  value["keep"] = view.flight.is_kept;
  // In this order; null until there is something to say.
  for (const char* field : {"revision", "job", "bounds", "georeferenced", "min_zoom", "max_zoom", "photos",
                            "captured", "gsd_m", "quality", "tilejson", "preview", "error"})
    value[field] = nullptr;
  value["may_change"] = view.may_change;
  const std::string tilejson = fmt::format("{}/tiles/{}.json", view.base_path, view.flight.id);
  if (view.job) {
    value["job"] = JobJson(*view.job, now);
    value["error"] = ErrorOf(*view.job);
  }
  if (const auto& map = view.revision) {
    value["revision"] = map->revision;
    value["bounds"] = map->bounds.ToArray();
    value["georeferenced"] = LiesSomewhere(map->bounds);
    value["min_zoom"] = map->min_zoom;
    value["max_zoom"] = map->max_zoom;
    value["photos"] = {{"total", map->photos_total},
                       {"aligned", map->photos_aligned},
                       {"pose_only", map->photos_pose_only},
                       {"left_out", map->photos_left_out}};
    if (!map->first_capture.empty())
      value["captured"] = {{"first", map->first_capture}, {"last", map->last_capture}};
    value["gsd_m"] = map->gsd_m;
    const ordered_json quality = ParseOrderedJson(map->quality);
    if (quality.is_object()) value["quality"] = quality;
    value["tilejson"] = tilejson;
  }
  if (view.preview) {
    value["preview"] = {{"edition", view.preview->edition},
                        {"photos", view.preview->photos},
                        {"bounds", view.preview->bounds.ToArray()},
                        {"tilejson", fmt::format("{}?rev={}", tilejson, kPreviewRevision)}};
  }
  return value;
}

ordered_json FileJson(const storage::StoredFile& file) {
  return {{"name", file.name}, {"bytes", file.bytes}};
}

ordered_json FileOutcomesJson(const std::vector<FileOutcome>& files) {
  ordered_json list = ordered_json::array();
  for (const FileOutcome& file : files) {
    if (file.error) {
      list.push_back(
          {{"name", file.name}, {"error", file.error->message}, {"code", ErrorCodeName(file.error->code)}});
      if (flight::HasReason(*file.error))
        list.back()["reason"] = flight::JsonOfRemark<ordered_json>(flight::WhyOf(*file.error));
    } else {
      list.push_back({{"name", file.name}, {"bytes", file.bytes}});
    }
    if (!file.note.empty()) list.back()["note"] = file.note;
  }
  return list;
}

Result<storage::FlightChange> ParseFlightFields(std::string_view body) {
  SKYQUILT_TRY_ASSIGN(const ordered_json parsed, ParseObject(body));
  storage::FlightChange fields;
  for (const auto& [field, value] : parsed.items()) {
    if (field == "name") {
      SKYQUILT_TRY_ASSIGN(fields.name, CheckedName(value));
    } else if (field == "options") {
      SKYQUILT_TRY_ASSIGN(fields.options, CheckedFlightOptions(value));
    } else if (field == "tags") {
      SKYQUILT_TRY_ASSIGN(fields.tags, CheckedTagList(value));
    } else if (field == "keep") {
      if (!value.is_boolean())
        return Error{ErrorCode::kUnprocessable, "The field \"keep\" must be true or false."};
      fields.is_kept = value.get<bool>();
    } else {
      return UnknownField(field);
    }
  }
  return fields;
}

Result<JobRequest> ParseJobRequest(std::string_view body) {
  SKYQUILT_TRY_ASSIGN(const ordered_json parsed, ParseObject(body));
  JobRequest request;
  for (const auto& [field, value] : parsed.items()) {
    if (field == "options") {
      SKYQUILT_TRY_ASSIGN(const std::string checked, CheckedOptions(value));
      request.options = checked;
    } else if (field == "priority") {
      SKYQUILT_TRY_ASSIGN(const int priority, CheckedPriority(value));
      request.priority = priority;
    } else {
      return UnknownField(field);
    }
  }
  return request;
}

}  // namespace skyquilt::api
