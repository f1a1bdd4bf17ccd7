#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/image/picture_codec.h"
#include "storage/files/publish_file.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxReportBytes = std::uintmax_t{512} << 20;

// Nothing where there is no such file, or where it is none: then it is said.
std::optional<nlohmann::json> ReadJson(const fs::path& path, std::vector<FileVerdict>& verdicts) {
  std::error_code gone;
  if (!fs::exists(path, gone)) return std::nullopt;
  FileVerdict& verdict = verdicts.emplace_back();
  verdict.file = path.filename().string();
  verdict.kind = "JSON";
  if (fs::file_size(path, gone) > kMaxReportBytes) {
    verdict.Add(Severity::kError, "it is larger than any that is written");
    return std::nullopt;
  }
  const Result<std::string> text = ReadWholeFile(path);
  if (!text) {
    verdict.Add(Severity::kError, "it cannot be read: " + text.error().message);
    return std::nullopt;
  }
  nlohmann::json value = ParseJson(*text);
  if (value.is_object()) return value;
  verdict.Add(Severity::kError, "it is no JSON object: cut off, or changed by hand");
  return std::nullopt;
}

std::optional<double> NumberAt(const nlohmann::json& value, const char* name) {
  const auto found = value.find(name);
  if (found == value.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<geo::LatLonBounds> BoundsAt(const nlohmann::json& report) {
  const auto found = report.find("bounds");
  if (found == report.end() || !found->is_array() || found->size() != 4) return std::nullopt;
  std::array<double, 4> box{};
  for (std::size_t i = 0; i < 4; ++i) {
    if (!(*found)[i].is_number()) return std::nullopt;
    box[i] = (*found)[i].get<double>();
  }
  return geo::LatLonBounds::FromArray(box);
}

double FarthestDeg(const geo::LatLonBounds& a, const geo::LatLonBounds& b) {
  double farthest = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    farthest = std::max(farthest, std::abs(a.ToArray()[i] - b.ToArray()[i]));
  return farthest;
}

void CompareTiles(const nlohmann::json& report, const FileVerdict& tiles, FileVerdict& verdict) {
  const auto compare = [&](const char* name, double is) {
    const auto said = NumberAt(report, name);
    if (!said)
      verdict.Add(Severity::kError, fmt::format("it has no {}", name));
    else if (*said != is)
      verdict.Add(Severity::kError, fmt::format("{} is {}, and {} has {}", name, *said, tiles.file, is));
  };
  if (!tiles.tiles) return;
  compare("tile_count", static_cast<double>(*tiles.tiles));
  compare("min_zoom", tiles.min_zoom);
  compare("max_zoom", tiles.max_zoom);
  if (tiles.tile_size_px > 0) compare("tile_size_px", tiles.tile_size_px);
}

void CompareBounds(const nlohmann::json& report, const FileVerdict& map, FileVerdict& verdict) {
  constexpr double kSameDeg = 2e-7;  // PMTiles has so many digits
  const auto said = BoundsAt(report);
  if (!said || !map.bounds) return;
  if (map.tiles) {
    if (FarthestDeg(*said, *map.bounds) > kSameDeg)
      verdict.Add(Severity::kError, "its bounds are not those of " + map.file);
    return;
  }
  // A GeoTIFF goes on to the edges of its tiles.
  const geo::LatLonBounds& b = *map.bounds;
  if (b.west_deg > said->west_deg + kSameDeg || b.east_deg < said->east_deg - kSameDeg ||
      b.south_deg > said->south_deg + kSameDeg || b.north_deg < said->north_deg - kSameDeg)
    verdict.Add(Severity::kError, map.file + " does not cover its bounds");
}

void ComparePhotos(const nlohmann::json& report, const nlohmann::json& photos, FileVerdict& verdict) {
  const auto features = photos.find("features");
  if (features == photos.end() || !features->is_array()) {
    verdict.Add(Severity::kError, "it has no features");
    return;
  }
  std::set<std::string> names;
  double aligned = 0.0, pose_only = 0.0;
  for (const nlohmann::json& feature : *features) {
    const auto none = nlohmann::json::object();
    const nlohmann::json properties = feature.is_object() ? feature.value("properties", none) : none;
    if (!properties.is_object()) continue;
    const auto text = [&](const char* name) { return TextIn(properties, name).value_or(""); };
    if (!names.insert(text("name")).second)
      verdict.Add(Severity::kError, "it has the photo \"" + text("name") + "\" twice");
    aligned += text("placement") == "aligned" ? 1.0 : 0.0;
    pose_only += text("placement") == "pose_only" ? 1.0 : 0.0;
  }
  const nlohmann::json counts = report.value("photos", nlohmann::json::object());
  if (!counts.is_object()) return;
  for (const auto& [name, is] : {std::pair{"aligned", aligned}, std::pair{"pose_only", pose_only}}) {
    const auto said = NumberAt(counts, name);
    if (said && *said != is)
      verdict.Add(Severity::kError,
                  fmt::format("it has {} photos \"{}\", and report.json counts {}", is, name, *said));
  }
}

}  // namespace

std::vector<FileVerdict> ValidateReports(const fs::path& folder, const std::vector<FileVerdict>& tiles) {
  std::vector<FileVerdict> verdicts;
  const auto report = ReadJson(folder / "report.json", verdicts);
  if (report) {
    for (const FileVerdict& map : tiles) {
      if (map.kind == "MBTiles") CompareTiles(*report, map, verdicts.back());
      CompareBounds(*report, map, verdicts.back());
    }
    std::optional<std::int64_t> count;
    for (const FileVerdict& map : tiles) {
      if (count && map.tiles && *map.tiles != *count)
        verdicts.back().Add(Severity::kError, fmt::format("{} has {} tiles, and mosaic.mbtiles has {}",
                                                          map.file, *map.tiles, *count));
      if (map.tiles && !count) count = map.tiles;
    }
  }
  const auto photos = ReadJson(folder / "photos.geojson", verdicts);
  if (photos && report) ComparePhotos(*report, *photos, verdicts.back());
  for (const char* name : {"locate.json", "cameras.json"}) (void)ReadJson(folder / name, verdicts);
  std::error_code gone;
  if (const fs::path picture = folder / "thumbnail.png"; fs::exists(picture, gone)) {
    FileVerdict& verdict = verdicts.emplace_back();
    verdict.file = "thumbnail.png";
    verdict.kind = "picture";
    const Result<std::string> bytes = ReadWholeFile(picture);
    if (!bytes || !image::DecodePicture(*bytes)) verdict.Add(Severity::kError, "it is a damaged picture");
  }
  for (const char* name : {"mosaic.mbtiles.tmp", "mosaic.mbtiles-journal"}) {
    if (!fs::exists(folder / name, gone)) continue;
    FileVerdict& verdict = verdicts.emplace_back();
    verdict.file = name;
    verdict.kind = "file of a run";
    verdict.Add(Severity::kNote, "a run works here, or was killed; the next one goes on from it");
  }
  return verdicts;
}

}  // namespace skyquilt::storage
