#include "storage/folder/disk_flights.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

Time ChangedAt(const fs::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  return FromUs(std::int64_t{status.st_mtim.tv_sec} * 1'000'000 + status.st_mtim.tv_nsec / 1000);
}

DiskFlight SurveyFlight(const fs::path& folder) {
  DiskFlight flight;
  flight.id = folder.filename().string();
  flight.folder = folder;
  std::error_code none;  // what cannot be read is not there for us, and stays where it is
  for (const auto& entry : fs::directory_iterator(folder / "files", none)) {
    const std::string name = entry.path().filename().string();
    std::error_code gone;
    if (!IsId(name) || !entry.is_regular_file(gone)) continue;
    const auto bytes = static_cast<std::int64_t>(entry.file_size(gone));
    if (!gone && bytes > 0) flight.files.push_back({name, bytes, ChangedAt(entry.path())});
  }
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const auto number = RevisionOfFolder(entry.path().filename().string());
    std::error_code gone;
    if (number && fs::is_regular_file(entry.path() / "mosaic.mbtiles", gone))
      flight.revisions.push_back(*number);
  }
  std::sort(flight.files.begin(), flight.files.end(),
            [](const DiskFile& a, const DiskFile& b) { return a.stored_name < b.stored_name; });
  std::sort(flight.revisions.begin(), flight.revisions.end());
  return flight;
}

// report.json; empty where it is missing or none.
Json ReportIn(const fs::path& folder) {
  Json json = ParseJsonFile(folder / "report.json");
  return json.is_object() ? json : Json::object();
}

int IntOr(const Json& json, const char* key, int fallback) {
  return json.is_object() && json.contains(key) && json[key].is_number_integer() ? json[key].get<int>()
                                                                                 : fallback;
}

}  // namespace

std::vector<DiskFlight> FlightsOnDisk(const fs::path& flights_folder) {
  std::vector<DiskFlight> flights;
  std::error_code none;  // a folder that is not there has no flights
  for (const auto& entry : fs::directory_iterator(flights_folder, none)) {
    std::error_code gone;
    if (IsId(entry.path().filename().string()) && entry.is_directory(gone))
      flights.push_back(SurveyFlight(entry.path()));
  }
  std::sort(flights.begin(), flights.end(),
            [](const DiskFlight& a, const DiskFlight& b) { return a.id < b.id; });
  return flights;
}

Result<std::vector<DiskFlight>> FlightsInBlobs(BlobStore& blobs) {
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> all, blobs.List("flights/"));
  std::map<std::string, DiskFlight> flights;
  for (const BlobInfo& blob : all) {
    const std::optional<FlightBlob> of_flight = FlightBlobOf(blob.key);
    if (!of_flight) continue;
    const auto& [id, folder, name] = *of_flight;
    DiskFlight& flight = flights[id];
    flight.id = id;
    const auto number = RevisionOfFolder(folder);
    if (folder == "files" && IsId(name))
      flight.files.push_back({name, blob.bytes, std::chrono::floor<std::chrono::microseconds>(blob.changed)});
    if (number && name == "mosaic.mbtiles") flight.revisions.push_back(*number);
  }
  std::vector<DiskFlight> found;
  for (auto& [id, flight] : flights) {
    std::sort(flight.revisions.begin(), flight.revisions.end());
    found.push_back(std::move(flight));
  }
  return found;
}

Result<Revision> RevisionOnDisk(const fs::path& revision_folder, std::int64_t number) {
  const fs::path tiles = revision_folder / "mosaic.mbtiles";
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(tiles));
  const auto& metadata = reader->metadata();
  Revision revision;
  revision.revision = number;
  revision.created = ChangedAt(tiles);
  revision.bounds = TilesetBounds(metadata).value_or(geo::LatLonBounds{-180.0, -85.0, 180.0, 85.0});
  const Json report = ReportIn(revision_folder);
  if (report.contains("bounds") && report["bounds"].is_array() && report["bounds"].size() == 4) {
    std::array<double, 4> read{};
    bool is_number = true;
    for (std::size_t i = 0; i < 4; ++i) {
      is_number = is_number && report["bounds"][i].is_number();
      if (is_number) read[i] = report["bounds"][i].get<double>();
    }
    if (is_number) revision.bounds = geo::LatLonBounds::FromArray(read);
  }
  revision.min_zoom = IntOr(report, "min_zoom", TilesetNumber(metadata, "minzoom", 0));
  revision.max_zoom = IntOr(report, "max_zoom", TilesetNumber(metadata, "maxzoom", 22));
  if (report.contains("gsd_m") && report["gsd_m"].is_number()) revision.gsd_m = report["gsd_m"].get<double>();
  const Json photos = report.contains("photos") ? report["photos"] : Json::object();
  revision.photos_total = IntOr(photos, "total", 0);
  revision.photos_aligned = IntOr(photos, "aligned", 0);
  revision.photos_pose_only = IntOr(photos, "pose_only", 0);
  revision.photos_left_out = IntOr(photos, "left_out", 0);
  const Json captured = report.contains("captured") ? report["captured"] : Json::object();
  revision.first_capture = TextIn(captured, "first").value_or("");
  revision.last_capture = TextIn(captured, "last").value_or("");
  if (report.contains("quality") && report["quality"].is_object())
    revision.quality = JsonText(report["quality"]);
  return revision;
}

}  // namespace skyquilt::storage
