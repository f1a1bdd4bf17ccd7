// all.zip: the map under the names that the node's clients know.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "api/downloads/send_file.h"
#include "api/downloads/streamed_product.h"
#include "api/downloads/zip_layout.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/nodeodm/node_options.h"
#include "api/nodeodm/nodeodm.h"
#include "api/routes.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;
namespace fs = std::filesystem;

std::string DumpIndented(const Value& value) { return JsonText(value, 1) + "\n"; }

Result<Value> ReadJson(const fs::path& path) {
  const Result<std::string> text = storage::ReadWholeFile(path);
  if (!text) return Error{ErrorCode::kNotFound, "Asset not ready", path.string()};
  Value parsed = ParseOrderedJson(*text);
  if (parsed.is_discarded())
    return Error{ErrorCode::kCorrupt, "A file of the map is damaged.", path.string()};
  return parsed;
}

// Camera positions as the clients' map shows them.
Value Shots(const Value& photos) {
  Value features = Value::array();
  for (const Value& photo : photos.value("features", Value::array())) {
    const Value& from = photo.at("properties");
    Value properties;
    properties["filename"] = from.value("name", "");
    properties["camera"] = from.value("camera", "");
    properties["capture_time"] = from.contains("captured_at") ? from["captured_at"] : Value(nullptr);
    properties["placement"] = from.value("placement", "");
    properties["yaw_deg"] = from.value("yaw_deg", 0.0);
    properties["pitch_deg"] = from.value("pitch_deg", 0.0);
    properties["roll_deg"] = from.value("roll_deg", 0.0);
    const Value position = {from.value("camera_lon", 0.0), from.value("camera_lat", 0.0),
                            from.value("camera_height_above_ground_m", 0.0)};
    features.push_back({{"type", "Feature"},
                        {"properties", properties},
                        {"geometry", {{"type", "Point"}, {"coordinates", position}}}});
  }
  return {{"type", "FeatureCollection"}, {"features", features}};
}

// How far off the ground control points that were used lie, in metres: across alone where no height was
// compared.
std::vector<double> ControlMisses(const Value& alignment) {
  std::vector<double> misses_m;
  for (const Value& point : alignment.value("ground_control", Value::array())) {
    if (!point.value("is_used", false)) continue;
    const auto up_m = point.find("miss_up_m");
    misses_m.push_back(std::hypot(point.value("miss_east_m", 0.0), point.value("miss_north_m", 0.0),
                                  up_m != point.end() && up_m->is_number() ? up_m->get<double>() : 0.0));
  }
  return misses_m;
}

Value Stats(const Value& report, const Value& photos) {
  Value first = nullptr;
  Value last = nullptr;
  for (const Value& photo : photos.value("features", Value::array())) {
    const Value& time = photo.at("properties").at("captured_at");
    if (!time.is_string()) continue;
    if (first.is_null() || time < first) first = time;
    if (last.is_null() || last < time) last = time;
  }
  double total_s = 0.0;
  Value steps = Value::object();
  for (const Value& timing : report.value("timings", Value::array())) {
    steps[timing.value("stage", "")] = timing.value("wall_s", 0.0);
    total_s += timing.value("wall_s", 0.0);
  }
  Value stats;
  stats["processing_statistics"] = {{"area", report.value("area_m2", 0.0)},
                                    {"start_date", first},
                                    {"end_date", last},
                                    {"date", last},
                                    {"steps_times", steps}};
  stats["odm_processing_statistics"] = {{"total_time", total_s},
                                        {"average_gsd", report.value("gsd_m", 0.0) * 100.0}};  // cm
  const Value& counts = report.at("photos");
  const Value alignment = report.value("alignment", Value::object());
  const std::vector<double> misses_m = ControlMisses(alignment);
  stats["reconstruction_statistics"] = {
      {"has_gps", report.value("is_placed", false)},
      {"has_gcp", !misses_m.empty()},
      {"initial_shots_count", counts.value("total", 0)},
      {"reconstructed_shots_count", counts.value("aligned", 0) + counts.value("pose_only", 0)},
      {"reconstructed_points_count", alignment.value("tie_points", 0)}};
  if (!misses_m.empty()) {
    const double sum_m = std::accumulate(misses_m.begin(), misses_m.end(), 0.0);
    stats["gcp_errors"] = {{"average_error", sum_m / static_cast<double>(misses_m.size())}};
  }
  return stats;
}

constexpr std::string_view kArchiveMbtiles = "odm_orthophoto/odm_orthophoto.mbtiles";
constexpr std::string_view kArchivePmtiles = "odm_orthophoto/odm_orthophoto.pmtiles";

// Our file, and where clients expect it. What a revision does not have is left out.
constexpr std::pair<const char*, std::string_view> kFiles[] = {
    {"mosaic.tif", "odm_orthophoto/odm_orthophoto.tif"},
    {"mosaic.mbtiles", kArchiveMbtiles},
    {"mosaic.pmtiles", kArchivePmtiles},
    {"bands.tif", "odm_orthophoto/bands.tif"},
    {"dsm.tif", "odm_dem/dsm.tif"},
    {"dtm.tif", "odm_dem/dtm.tif"},
    {"contours.gpkg", "odm_dem/contours.gpkg"},
    {"cameras.json", "cameras.json"},
    {"geo.txt", "geo.txt"},
    {"report.html", "odm_report/report.html"},
    {"report.json", "odm_report/report.json"},
    {"photos.geojson", "odm_report/footprints.geojson"},
};

// `files_in_use`: what the entries' files are held by.
Result<std::vector<ZipEntry>> EntriesOf(Service& service, const storage::NodeTask& task,
                                        const std::string& prefix,
                                        std::vector<storage::LocalBlob>& files_in_use) {
  storage::BlobStore& blobs = service.store.blobs();
  std::vector<ZipEntry> entries;
  for (const auto& [ours, theirs] : kFiles) {
    Result<storage::LocalBlob> file = blobs.Local(prefix + ours);
    if (!file && file.error().code != ErrorCode::kNotFound) return file.error();
    if (!file) {
      Result<storage::OpenStreamed> streamed = OpenStreamedProduct(service, prefix, ours);
      if (!streamed && streamed.error().code != ErrorCode::kNotFound) return streamed.error();
      if (streamed) entries.push_back({std::string(theirs), "", {}, *std::move(streamed)});
      continue;
    }
    entries.push_back({std::string(theirs), "", file->path, {}});
    files_in_use.push_back(*std::move(file));
  }
  const fs::path folder = blobs.FolderOf(prefix);
  SKYQUILT_TRY_ASSIGN(const Value report, ReadJson(folder / "report.json"));
  SKYQUILT_TRY_ASSIGN(const Value photos, ReadJson(folder / "photos.geojson"));
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::StoredFile> files,
                      service.catalogue.ListFiles(task.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> lines, NodeOutput(service, task));
  Value images = Value::array();
  for (const storage::StoredFile& file : files)
    images.push_back({{"filename", file.name}, {"size", file.bytes}});
  std::string output;
  for (const std::string& line : lines) output += line + "\n";
  entries.push_back({"odm_report/shots.geojson", DumpIndented(Shots(photos)), {}, {}});
  entries.push_back({"odm_report/stats.json", DumpIndented(Stats(report, photos)), {}, {}});
  entries.push_back({"images.json", DumpIndented(images), {}, {}});
  entries.push_back({"task_output.txt", output, {}, {}});
  entries.push_back({"log.json",
                     DumpIndented({{"options", ParseOrderedJson(task.options)},
                                   {"timings", report.value("timings", Value::array())}}),
                     {},
                     {}});
  return entries;
}

std::string ArchiveTiles(const storage::NodeTask& task) {
  for (const Value& option : ParseOrderedJson(task.options)) {
    if (option.value("name", "") == "archive-tiles") return option.value("value", kUsualArchiveTiles);
  }
  return kUsualArchiveTiles;
}

bool IsWithin(std::string_view path, std::string_view wanted) {
  while (wanted.ends_with('/')) wanted.remove_suffix(1);
  return path == wanted || (path.starts_with(wanted) && path.substr(wanted.size()).starts_with('/'));
}

// Of all that there is, what the task asked for by paths or by the kind of its tiles. The GeoTIFF has the
// whole pyramid of the tiles, and so has each of their files.
void KeepWanted(const storage::NodeTask& task, std::vector<ZipEntry>& entries) {
  const Value outputs = ParseOrderedJson(task.outputs);
  const std::string tiles = ArchiveTiles(task);
  const auto is_wanted = [&](const ZipEntry& entry) {
    if (outputs.is_array() && !outputs.empty()) {
      return std::any_of(outputs.begin(), outputs.end(), [&](const Value& wanted) {
        return IsWithin(entry.name, wanted.get_ref<const std::string&>());
      });
    }
    if (entry.name == kArchiveMbtiles) return tiles == "mbtiles" || tiles == "both";
    if (entry.name == kArchivePmtiles) return tiles == "pmtiles" || tiles == "both";
    return true;
  };
  const auto output = std::find_if(entries.begin(), entries.end(),
                                   [](const ZipEntry& entry) { return entry.name == "task_output.txt"; });
  const ZipEntry told = *output;
  std::erase_if(entries, [&](const ZipEntry& entry) { return !is_wanted(entry); });
  if (entries.empty()) entries.push_back(told);  // an archive of nothing is none
}

Result<Response> Archive(Service& service, const Request& request, const storage::NodeTask& task) {
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(task.flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::Job> job, service.queue.LatestOf(task.flight_id));
  const bool is_done = job && job->state == storage::JobState::kSuccessful;
  if (!flight.active_revision || !is_done) return Error{ErrorCode::kNotFound, "Asset not ready"};
  std::vector<storage::LocalBlob> files_in_use;  // until the archive has opened them
  SKYQUILT_TRY_ASSIGN(
      std::vector<ZipEntry> entries,
      EntriesOf(service, task, storage::RevisionPrefix(task.flight_id, *flight.active_revision),
                files_in_use));
  KeepWanted(task, entries);
  SKYQUILT_TRY_ASSIGN(ZipLayout planned, PlanZip(entries));
  const auto layout = std::make_shared<const ZipLayout>(std::move(planned));
  return SendParts(
      request, layout->length, "application/zip", ZipEtag(*layout),
      [&](std::uint64_t offset, std::uint64_t length) { return ReadZip(layout, offset, length); });
}

Result<Response> Download(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const storage::NodeTask task, FindNodeTask(service, request.Parameter("uuid")));
  if (request.Parameter("asset") != "all.zip") return NodeRefusal("Invalid asset");
  Result<Response> sent = Archive(service, request, task);
  // What HTTP itself has a status for.
  const auto is = [&](ErrorCode code) { return !sent && sent.error().code == code; };
  if (is(ErrorCode::kRangeNotSatisfiable) || is(ErrorCode::kPreconditionFailed))
    return Downloaded(std::move(sent), request);
  if (sent) sent->headers.Add("Content-Disposition", "attachment; filename=\"all.zip\"");
  return sent;
}

}  // namespace

void AddNodeArchiveRoute(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/task/{uuid}/download/{asset}", On(service, Download, NodeProblem));
}

}  // namespace skyquilt::api
