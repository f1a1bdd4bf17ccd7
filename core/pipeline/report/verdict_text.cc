#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/text/json_io.h"
#include "core/base/text/printable.h"
#include "core/flight/aside/aside.h"
#include "core/flight/remarks/remark_json.h"
#include "core/pipeline/inspect_flight.h"
#include "core/pipeline/report/report_codec.h"
#include "core/poses/lists/list_words.h"

namespace skyquilt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

std::string Counts(const std::map<std::string, int>& counts) {
  std::string text;
  for (const auto& [what, count] : counts)
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", Printable(what), count);
  return text;
}

std::string LogText(const flight::LogFacts& log) {
  std::string text = fmt::format("Log         {} ({})", Printable(log.file_name), log.format);
  if (log.events_by_name > 0)
    text += fmt::format(", {} a photo", Counted(log.events_by_name, "row that names", "rows that name"));
  if (!log.begins_at.empty()) text += ", from " + log.begins_at;
  text += "\n";
  for (const auto& [name, series] : log.series) {
    text += fmt::format("            {:<9} {:>7} at {:.4g} Hz, {:.0f} s, longest gap {:.2f} s\n", name,
                        series.count, series.rate_hz, series.end_s - series.begin_s, series.longest_gap_s);
  }
  for (const std::string& column : log.mapping) text += fmt::format("            {}\n", Printable(column));
  for (const std::string& advice : log.advice) text += fmt::format("            {}\n", Printable(advice));
  return text;
}

Json LogJson(const flight::LogFacts& log) {
  Json series = Json::object();
  for (const auto& [name, facts] : log.series) {
    series[name] = {{"count", facts.count},
                    {"rate_hz", facts.rate_hz},
                    {"longest_gap_s", facts.longest_gap_s},
                    {"begin_s", facts.begin_s},
                    {"end_s", facts.end_s}};
  }
  Json json{{"name", log.file_name}, {"format", log.format}, {"series", series}};
  json["begins_at"] = log.begins_at;
  json["messages"] = log.message_counts;
  json["rows_by_name"] = log.events_by_name;
  json["mapping"] = log.mapping;
  json["advice"] = log.advice;
  return json;
}

const char* FaultWord(flight::ListFault fault) {
  constexpr std::array kWords = {"none",     "names_no_photo", "no_system",  "no_place",
                                 "far_away", "other_shape",    "other_time", "other_pixels"};
  static_assert(kWords.size() == static_cast<std::size_t>(flight::ListFault::kOtherPixels) + 1);
  return kWords[static_cast<std::size_t>(fault)];
}

Json ListJson(const flight::ListUse& use) {
  return {{"name", use.file_name},
          {"kind", use.kind == flight::ListKind::kControl ? "control" : "positions"},
          {"read_as", poses::ReadingInWords(use, use.reading)},
          {"as_written", use.is_as_written},
          {"rows", use.rows},
          {"rows_used", use.rows_used},
          {"apart_m", use.apart_m ? Json(*use.apart_m) : Json()},
          {"fault", FaultWord(use.fault)},
          {"words", poses::UseInWords(use)}};
}

// A line each of what came of the given files; what is said of lists already stands there.
std::string UsesText(const FlightVerdict& v) {
  std::string text;
  std::vector<std::string> uses;
  for (const flight::ListUse& use : v.lists) {
    uses.push_back(poses::UseInWords(use));
    text += fmt::format("List        {}\n", Printable(uses.back()));
  }
  for (const std::string& line : v.poses.logs) {
    if (std::find(uses.begin(), uses.end(), line) == uses.end())
      text += fmt::format("Used        {}\n", Printable(line));
  }
  return text;
}

std::string StatusText(const FlightVerdict& v) {
  const std::optional<MapStatus> status = ForeseenStatus(v);
  if (!status) return "Status      and accuracy come with the map, when photos have been compared\n";
  std::string text = fmt::format("Status      {}.", StatusInWords(*status));
  for (const MapLimit& limit : v.by_records.limits) text += " " + LimitInWords(limit);
  return text + "\n";
}

Json RecordsJson(const FlightVerdict& v) {
  const std::optional<MapStatus> status = ForeseenStatus(v);
  Json json = ParseOrderedJson(QualityJson(v.by_records));
  json.erase("relative");
  json["status"] = status ? Json(NameOf(*status)) : Json();
  return json;
}

}  // namespace

std::string VerdictText(const FlightVerdict& v) {
  std::string text = fmt::format("Photos      {} readable, {} can be placed, {} left out\n",
                                 v.photos_readable, v.photos_placeable, Counted(v.left_out.size(), "file"));
  for (const auto& [camera, count] : v.cameras)
    text += fmt::format("Camera      {} ({})\n", Printable(camera), count);
  if (!v.first_capture.empty())
    text += fmt::format("Taken       {} to {}\n", v.first_capture, v.last_capture);
  if (!v.position_sources.empty()) text += "Positions   " + Counts(v.position_sources) + "\n";
  if (!v.attitude_sources.empty()) text += "Angles      " + Counts(v.attitude_sources) + "\n";
  for (const flight::LogFacts& log : v.logs) text += LogText(log);
  text += UsesText(v);
  for (const std::string& list : v.gcp_lists) text += fmt::format("Control     {}\n", Printable(list));
  for (const std::string& model : v.elevation_models)
    text += fmt::format("Heights     {}: an elevation model of the ground\n", Printable(model));
  if (!v.poses.time_match.empty()) {
    text += fmt::format("Clock       {}", v.poses.time_match);
    if (v.poses.camera_ahead_of_utc_s) {
      text += fmt::format("; the camera is {:.2f} s ahead of UTC (+-{:.3f} s)",
                          *v.poses.camera_ahead_of_utc_s, v.poses.time_sigma_s.value_or(0.0));
    }
    text += "\n";
  }
  if (!v.poses.method.empty()) {
    text += fmt::format("Poses       {}: {} by the log, {} by their own records\n", v.poses.method,
                        Counted(v.poses.photos_by_log, "photo"), v.poses.photos_by_records);
  }
  if (!v.poses.convention.empty()) text += fmt::format("Convention  {}\n", v.poses.convention);
  if (v.photos_placeable > 0) {
    text += fmt::format("Height      {:.0f} to {:.0f} m above ground: {}\n", v.lowest_m, v.highest_m,
                        v.height_rule);
    text += fmt::format("Ground      {:.2f} ha at {:.1f} cm a pixel", v.area_m2 / 1e4, 100.0 * v.gsd_m);
    if (v.forward_overlap) text += fmt::format(", {:.0f} % forward overlap", 100.0 * *v.forward_overlap);
    text += fmt::format(", {:.1f} photos a point\n", v.mean_photos_per_point);
    text +=
        fmt::format("Records     {}: what they claim before any photo is looked at, not the map's accuracy\n",
                    AbsoluteInWords(v.by_records));
    text += StatusText(v);
    text += fmt::format("Map         {:.0f} megapixels, finest zoom {} with tiles of {} px\n",
                        v.output_megapixels, v.max_zoom, v.tile_size_px);
    text += fmt::format("Cost        about {:.0f} s and {:.0f} MiB of memory on this machine\n",
                        v.expected_seconds, v.expected_memory_mib);
  }
  for (const std::string& line : flight::LeftOutInLines(v.left_out))
    text += fmt::format("Left out    {}\n", Printable(line));
  for (const std::string& warning : flight::InWords(v.warnings))
    text += fmt::format("Note        {}\n", Printable(warning));
  return text;
}

std::string VerdictJson(const FlightVerdict& v) {
  Json logs = Json::array();
  for (const flight::LogFacts& log : v.logs) logs.push_back(LogJson(log));
  Json lists = Json::array();
  for (const flight::ListUse& use : v.lists) lists.push_back(ListJson(use));
  const Json json{{"photos_readable", v.photos_readable},
                  {"photos_placeable", v.photos_placeable},
                  {"photos_by_images", v.photos_by_images},
                  {"cameras", v.cameras},
                  {"position_sources", v.position_sources},
                  {"attitude_sources", v.attitude_sources},
                  {"logs", logs},
                  {"lists", lists},
                  {"gcp_lists", v.gcp_lists},
                  {"elevation_models", v.elevation_models},
                  {"poses", JsonOf<Json>(v.poses)},
                  {"first_capture", v.first_capture},
                  {"last_capture", v.last_capture},
                  {"height_rule", v.height_rule},
                  {"lowest_m", v.lowest_m},
                  {"highest_m", v.highest_m},
                  {"gsd_m", v.gsd_m},
                  {"area_m2", v.area_m2},
                  {"forward_overlap", v.forward_overlap ? Json(*v.forward_overlap) : Json()},
                  {"mean_photos_per_point", v.mean_photos_per_point},
                  {"by_records", RecordsJson(v)},
                  {"max_zoom", v.max_zoom},
                  {"tile_size_px", v.tile_size_px},
                  {"output_megapixels", v.output_megapixels},
                  {"expected_seconds", v.expected_seconds},
                  {"expected_memory_mib", v.expected_memory_mib},
                  {"left_out", JsonOfLeftOut<Json>(v.left_out)},
                  {"warnings", flight::InWords(v.warnings)},
                  {"remarks", flight::JsonOfRemarks<Json>(v.warnings)}};
  return JsonText(json, 2) + "\n";
}

}  // namespace skyquilt::pipeline
