#include "server/jobs/child_messages.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/pipeline/report/map_quality.h"
#include "server/sandbox/sandboxed_child.h"
#include "storage/db/ids.h"

namespace skyquilt::server {

// Members that stand in JSON by their own names.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UnitToDo, kind, number, count, blocks, looks)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StitchTask, files_dir, previous_dir, out_dir, options, title, units_dir,
                                   renders, with_pmtiles, memory_bytes, cpu_s)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExportTask, map_dir, work_dir, out_name, request, threads, memory_bytes,
                                   cpu_s, file_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PreviewPlace, files_dir, folder, memory_bytes)

namespace {

using Json = nlohmann::json;

constexpr int kMaxPhotos = 10'000'000;  // that a message may speak of
constexpr int kMaxZoom = 30;
constexpr std::size_t kMaxForgone = 64;
constexpr std::size_t kMaxStageBytes = 32;
constexpr std::size_t kMaxStages = 64;
constexpr std::size_t kMaxQualityBytes = 2000;
constexpr std::size_t kMaxTimeBytes = 25;  // "2015-10-27T09:31:02-04:00"
constexpr std::size_t kMaxMessageChars = 500;

// What came over the pipe is not what our own code would have sent.
Error Untrue(std::string detail) {
  return {ErrorCode::kUnprocessable, "The process that works on the photos said what makes no sense.",
          std::move(detail)};
}

bool IsWithin(double value, double least, double most) { return value >= least && value <= most; }

// A number beyond 0..kMaxPhotos comes as -1, which no figure is.
int CountOf(double value) { return IsWithin(value, 0, kMaxPhotos) ? static_cast<int>(value) : -1; }

// On Earth, also across the antimeridian.
bool AreBounds(const geo::LatLonBounds& bounds) {
  const auto& [west, south, east, north] = bounds;
  return IsWithin(west, -180, 180) && IsWithin(east, west, west + 360) && IsWithin(south, -90, 90) &&
         IsWithin(north, south, 90);
}

bool AreZooms(int min_zoom, int max_zoom) {
  return IsWithin(min_zoom, 0, kMaxZoom) && IsWithin(max_zoom, min_zoom, kMaxZoom);
}

// Texts of photos may hold any bytes: those that are no UTF-8 are replaced.
std::string Dump(const Json& json) { return JsonText(json); }

// What `parse` makes of a text that is JSON with the members it looks for.
template <typename Parse>
auto Guarded(std::string_view text, Parse parse) -> decltype(parse(Json())) {
  try {
    return parse(ParseJson(text));
  } catch (const Json::exception& broken) {
    return Untrue(broken.what());
  }
}

// A time of ISO 8601, or nothing.
bool IsTime(const std::string& text) {
  return text.size() <= kMaxTimeBytes && text.find_first_not_of("0123456789-:+TZ") == std::string::npos;
}

// 1 to 32 of a-z, 0-9, _ and -.
bool IsStage(const std::string& stage) {
  return !stage.empty() && stage.size() <= kMaxStageBytes &&
         std::all_of(stage.begin(), stage.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
         });
}

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

Json FilesJson(const std::vector<storage::StoredFile>& files) {
  Json list = Json::array();
  for (const storage::StoredFile& file : files) list.push_back({file.name, file.stored_name});
  return list;
}

std::vector<storage::StoredFile> FilesOf(const Json& list) {
  std::vector<storage::StoredFile> files;
  for (const Json& file : list) files.push_back({file.at(0), file.at(1), 0});
  return files;
}

Json PreviewJson(const std::optional<storage::Preview>& preview) {
  if (!preview) return nullptr;
  return {{"photos", preview->photos},
          {"min_zoom", preview->min_zoom},
          {"max_zoom", preview->max_zoom},
          {"bounds", preview->bounds.ToArray()},
          {"changed", preview->changed.ToArray()}};
}

std::optional<storage::Preview> PreviewOf(const Json& json) {
  if (json.is_null()) return std::nullopt;
  storage::Preview preview;
  preview.photos = CountOf(json.at("photos"));
  preview.min_zoom = CountOf(json.at("min_zoom"));
  preview.max_zoom = CountOf(json.at("max_zoom"));
  preview.bounds = geo::LatLonBounds::FromArray(json.at("bounds"));
  preview.changed = geo::LatLonBounds::FromArray(json.at("changed"));
  return preview;
}

Result<PreviewMessage> CheckedDrawn(const Json& json) {
  PreviewDrawn drawn{PreviewOf(json.at("preview")), json.at("forgone")};
  if (drawn.forgone.size() > kMaxForgone) return Untrue("too many photos");
  for (const std::string& name : drawn.forgone) {
    if (!storage::IsId(name)) return Untrue("a stored name is none of ours");
  }
  if (drawn.preview) {
    const storage::Preview& preview = *drawn.preview;
    if (preview.photos < 1 || !AreZooms(preview.min_zoom, preview.max_zoom) || !AreBounds(preview.bounds) ||
        !AreBounds(preview.changed)) {
      return Untrue("figures that no preview has");
    }
  }
  return PreviewMessage(std::move(drawn));
}

}  // namespace

std::string ToText(const StitchTask& task) {
  Json files = Json::array();
  for (const flight::InputFile& file : task.files) files.push_back({file.name, file.path.string()});
  Json json = task;
  json["files"] = std::move(files);
  json["unit"] = task.unit ? Json(*task.unit) : Json(nullptr);
  return Dump(json);
}

Result<StitchTask> ParseTask(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<StitchTask> {
    auto task = json.get<StitchTask>();
    for (const Json& file : json.at("files"))
      task.files.push_back({file.at(0).get<std::string>(), file.at(1).get<std::string>()});
    if (const Json& unit = json.at("unit"); !unit.is_null()) task.unit = unit.get<UnitToDo>();
    return task;
  });
}

std::string ToText(const ExportTask& task) { return Dump(task); }

Result<ExportTask> ParseExportTask(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<ExportTask> { return json.get<ExportTask>(); });
}

std::string ToText(const JobMessage& message) {
  if (const auto* begun = std::get_if<StageBegun>(&message)) return Dump({{"stage", begun->stage}});
  if (const auto* progress = std::get_if<StageProgress>(&message)) {
    const double fraction =
        std::isfinite(progress->fraction) ? std::clamp(progress->fraction, 0.0, 1.0) : 0.0;
    return Dump({{"fraction", fraction}, {"message", CutToBytes(progress->message, kMaxMessageChars)}});
  }
  if (const auto* outcome = std::get_if<StitchOutcome>(&message)) return Dump({{"done", JsonOf(*outcome)}});
  return Dump({{"error", ErrorJson(std::get<Error>(message))}});
}

Result<JobMessage> ParseJobMessage(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<JobMessage> {
    if (json.contains("stage")) {
      StageBegun begun{json.at("stage")};
      if (!IsStage(begun.stage)) return Untrue("a stage that is none");
      return JobMessage(std::move(begun));
    }
    if (json.contains("fraction")) {
      StageProgress progress{json.at("fraction"), json.at("message")};
      if (!IsWithin(progress.fraction, 0.0, 1.0) || !IsShort(progress.message, kMaxMessageChars))
        return Untrue("no progress");
      return JobMessage(std::move(progress));
    }
    if (json.contains("done")) {
      StitchOutcome outcome = OutcomeOf(json.at("done"));
      if (const auto wrong = WhatIsWrong(outcome)) return *wrong;
      return JobMessage(std::move(outcome));
    }
    std::optional<Error> error = ErrorOfJson(json.at("error"));
    if (!error) return Untrue("an error that is none");
    return JobMessage(*std::move(error));
  });
}

std::string ToText(const PreviewPlace& place) { return Dump(place); }

Result<PreviewPlace> ParsePlace(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewPlace> { return json.get<PreviewPlace>(); });
}

std::string ToText(const PreviewRequest& request) {
  return Dump({{"fresh", FilesJson(request.fresh)},
               {"tried", FilesJson(request.tried)},
               {"preview", PreviewJson(request.preview)}});
}

Result<PreviewRequest> ParseRequest(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewRequest> {
    return PreviewRequest{FilesOf(json.at("fresh")), FilesOf(json.at("tried")),
                          PreviewOf(json.at("preview"))};
  });
}

std::string ToText(const PreviewMessage& message) {
  if (const auto* begun = std::get_if<PhotoBegun>(&message)) return Dump({{"photo", begun->stored_name}});
  if (const auto* drawn = std::get_if<PreviewDrawn>(&message))
    return Dump({{"preview", PreviewJson(drawn->preview)}, {"forgone", drawn->forgone}});
  return Dump({{"error", ErrorJson(std::get<Error>(message))}});
}

Result<PreviewMessage> ParsePreviewMessage(std::string_view text) {
  return Guarded(text, [](const Json& json) -> Result<PreviewMessage> {
    if (json.contains("photo")) {
      PhotoBegun begun{json.at("photo")};
      if (!storage::IsId(begun.stored_name)) return Untrue("a stored name is none of ours");
      return PreviewMessage(std::move(begun));
    }
    if (json.contains("preview")) return CheckedDrawn(json);
    std::optional<Error> error = ErrorOfJson(json.at("error"));
    if (!error) return Untrue("an error that is none");
    return PreviewMessage(*std::move(error));
  });
}

}  // namespace skyquilt::server
