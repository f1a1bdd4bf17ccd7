#include "server/jobs/job_messages.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/remark_json.h"
#include "core/pipeline/report/map_quality.h"
#include "server/sandbox/message_checks.h"

namespace skyquilt::server {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxStageBytes = 32;
constexpr std::size_t kMaxStages = 64;
constexpr std::size_t kMaxQualityBytes = 2000;
constexpr std::size_t kMaxTimeBytes = 25;  // "2015-10-27T09:31:02-04:00"
constexpr std::size_t kMaxMessageChars = 500;
constexpr std::size_t kMaxReasonBytes = 16 * 1024;
// A byte that is no UTF-8 is sent as the three of the replacement character.
constexpr std::size_t kMaxGrowth = 3;

// Texts of photos may hold any bytes: those that are no UTF-8 are replaced.
std::string DumpJob(const Json& json) { return JsonText(json); }

// A time of ISO 8601, or nothing.
bool IsTime(const std::string& text) {
  return text.size() <= kMaxTimeBytes && text.find_first_not_of("0123456789-:+TZ") == std::string::npos;
}

bool IsStage(const std::string& stage) { return IsWord(stage, kMaxStageBytes); }

std::optional<Error> WhatIsWrong(const StitchOutcome& outcome) {
  const storage::Revision& map = outcome.figures;
  if (!AreBounds(map.bounds)) return Untrue("bounds that are not on Earth");
  if (!AreZooms(map.min_zoom, map.max_zoom)) return Untrue("zooms that no map has");
  if (!IsWithin(map.gsd_m, 0, 1e6)) return Untrue("a resolution that no map has");
  for (const int count : {map.photos_total, map.photos_aligned, map.photos_pose_only, map.photos_left_out}) {
    if (!IsWithin(count, 0, kMaxPhotos)) return Untrue("a number of photos that no flight has");
  }
  if (!IsTime(map.first_capture) || !IsTime(map.last_capture)) return Untrue("a time that is none");
  if (map.quality.size() > kMaxQualityBytes) return Untrue("a quality that no map has");
  if (!map.quality.empty()) {
    const Result<pipeline::MapQuality> quality = pipeline::ParseQuality(map.quality);
    if (!quality || pipeline::QualityJson(*quality) != map.quality)
      return Untrue("a quality that no map has");
  }
  constexpr std::int64_t kMaxBlocks = std::int64_t{1} << 32;
  if (outcome.blocks < 0 || outcome.blocks > kMaxBlocks) return Untrue("a number of blocks that no map has");
  if (outcome.stages_s.size() > kMaxStages) return Untrue("too many stages");
  for (const auto& [stage, wall_s] : outcome.stages_s) {
    if (!IsStage(stage) || !IsWithin(wall_s, 0, 1e9)) return Untrue("a stage that is none");
  }
  return std::nullopt;
}

StitchOutcome OutcomeOf(const Json& json) {
  StitchOutcome outcome;
  storage::Revision& map = outcome.figures;
  map.bounds = geo::LatLonBounds::FromArray(json.at("bounds"));
  map.min_zoom = CountOf(json.at("min_zoom"));
  map.max_zoom = CountOf(json.at("max_zoom"));
  map.gsd_m = json.at("gsd_m");
  map.photos_total = CountOf(json.at("photos_total"));
  map.photos_aligned = CountOf(json.at("photos_aligned"));
  map.photos_pose_only = CountOf(json.at("photos_pose_only"));
  map.photos_left_out = CountOf(json.at("photos_left_out"));
  map.first_capture = json.at("first_capture").get<std::string>();
  map.last_capture = json.at("last_capture").get<std::string>();
  map.quality = json.at("quality").get<std::string>();
  outcome.blocks = json.at("blocks");
  outcome.stages_s = json.at("stages_s").get<std::vector<std::pair<std::string, double>>>();
  return outcome;
}

Json JsonOf(const StitchOutcome& outcome) {
  const storage::Revision& map = outcome.figures;
  return {{"bounds", map.bounds.ToArray()},
          {"min_zoom", map.min_zoom},
          {"max_zoom", map.max_zoom},
          {"gsd_m", map.gsd_m},
          {"photos_total", map.photos_total},
          {"photos_aligned", map.photos_aligned},
          {"photos_pose_only", map.photos_pose_only},
          {"photos_left_out", map.photos_left_out},
          {"first_capture", map.first_capture},
          {"last_capture", map.last_capture},
          {"quality", map.quality},
          {"blocks", outcome.blocks},
          {"stages_s", outcome.stages_s}};
}

Json JsonOf(const std::optional<UnitToDo>& unit) {
  if (!unit) return nullptr;
  return {{"kind", static_cast<int>(unit->kind)},
          {"number", unit->number},
          {"count", unit->count},
          {"blocks", unit->blocks},
          {"looks", unit->looks}};
}

std::optional<UnitToDo> UnitOf(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return UnitToDo{static_cast<UnitKind>(json.at("kind").get<int>()), json.at("number"), json.at("count"),
                  json.at("blocks"), json.at("looks")};
}

}  // namespace

std::string ToText(const StitchTask& task) {
  Json files = Json::array();
  for (const flight::InputFile& file : task.files) files.push_back({file.name, file.path.string()});
  return DumpJob({{"files", files},
                  {"files_dir", task.files_dir.string()},
                  {"previous_dir", task.previous_dir.string()},
                  {"out_dir", task.out_dir.string()},
                  {"options", task.options},
                  {"title", task.title},
                  {"units_dir", task.units_dir.string()},
                  {"unit", JsonOf(task.unit)},
                  {"renders", task.renders},
                  {"with_pmtiles", task.with_pmtiles},
                  {"memory_bytes", task.memory_bytes},
                  {"cpu_s", task.cpu_s}});
}

Result<StitchTask> ParseTask(std::string_view text) {
  try {
    const Json json = ParseJson(text);
    StitchTask task;
    for (const Json& file : json.at("files"))
      task.files.push_back({file.at(0).get<std::string>(), file.at(1).get<std::string>()});
    task.files_dir = json.at("files_dir").get<std::string>();
    task.previous_dir = json.at("previous_dir").get<std::string>();
    task.out_dir = json.at("out_dir").get<std::string>();
    task.options = json.at("options");
    task.title = json.at("title");
    task.units_dir = json.at("units_dir").get<std::string>();
    task.unit = UnitOf(json.at("unit"));
    task.renders = json.at("renders");
    task.with_pmtiles = json.at("with_pmtiles");
    task.memory_bytes = json.at("memory_bytes");
    task.cpu_s = json.at("cpu_s");
    return task;
  } catch (const Json::exception& broken) {
    return Untrue(broken.what());
  }
}

std::string ToText(const JobMessage& message) {
  if (const auto* begun = std::get_if<StageBegun>(&message)) return DumpJob({{"stage", begun->stage}});
  if (const auto* progress = std::get_if<StageProgress>(&message)) {
    const double fraction =
        std::isfinite(progress->fraction) ? std::clamp(progress->fraction, 0.0, 1.0) : 0.0;
    return DumpJob({{"fraction", fraction}, {"message", Shortened(progress->message, kMaxMessageChars)}});
  }
  if (const auto* outcome = std::get_if<StitchOutcome>(&message))
    return DumpJob({{"done", JsonOf(*outcome)}});
  const Error& error = std::get<Error>(message);
  Json said = {{"code", static_cast<int>(error.code)},
               {"message", Shortened(error.message, kMaxErrorBytes)},
               {"detail", Shortened(error.detail, kMaxErrorBytes)}};
  if (error.reason != nullptr) {
    Json reason = flight::JsonOfRemark<Json>(*error.reason);
    if (DumpJob(reason).size() <= kMaxReasonBytes) said["reason"] = std::move(reason);
  }
  return DumpJob({{"error", std::move(said)}});
}

Result<JobMessage> ParseJobMessage(std::string_view text) {
  try {
    const Json json = ParseJson(text);
    if (json.contains("stage")) {
      StageBegun begun{json.at("stage")};
      if (!IsStage(begun.stage)) return Untrue("a stage that is none");
      return JobMessage(std::move(begun));
    }
    if (json.contains("fraction")) {
      StageProgress progress{json.at("fraction"), json.at("message")};
      if (!IsWithin(progress.fraction, 0.0, 1.0) || progress.message.size() > kMaxGrowth * kMaxMessageChars)
        return Untrue("no progress");
      return JobMessage(std::move(progress));
    }
    if (json.contains("done")) {
      StitchOutcome outcome = OutcomeOf(json.at("done"));
      if (const auto wrong = WhatIsWrong(outcome)) return *wrong;
      return JobMessage(std::move(outcome));
    }
    const Json& said = json.at("error");
    const int code = CountOf(said.at("code"));
    const auto known = std::find_if(kAllErrorCodes.begin(), kAllErrorCodes.end(),
                                    [&](ErrorCode one) { return static_cast<int>(one) == code; });
    Error error{ErrorCode::kInternal, said.at("message"), said.at("detail")};
    if (known == kAllErrorCodes.end() || error.message.size() > kMaxGrowth * kMaxErrorBytes ||
        error.detail.size() > kMaxGrowth * kMaxErrorBytes) {
      return Untrue("an error that is none");
    }
    error.code = *known;
    if (said.contains("reason")) {
      const Json& reason = said.at("reason");
      if (DumpJob(reason).size() > kMaxReasonBytes) return Untrue("a reason that is none");
      error.reason = std::make_shared<const flight::Remark>(flight::RemarkOfJson(reason));
    }
    return JobMessage(std::move(error));
  } catch (const Json::exception& broken) {
    return Untrue(broken.what());
  }
}

}  // namespace skyquilt::server
