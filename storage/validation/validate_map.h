// ValidateMap: whether a map is sound, of ours or of anybody: an MBTiles (1.3), a PMTiles (3), a GeoTIFF with
// the layout of a cloud-optimised one, or the folder of a map of ours with what its files say of each other.
// Files are only read. Foreign bytes: every reader is bounded; not for processes that serve others. Blocking.
// Errors: kNotFound, kUnsupportedFormat (no map), kIo, kCancelled. What is wrong with a map is no error but a
// finding.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::storage {

// What was found wrong, doubtful or worth saying of one file of a map, in sentences for a
// person. What is the same of many tiles is said once, with how many and the first of them (CountedFindings).
// One thread.
enum class Severity { kError, kWarning, kNote };
const char* SeverityName(Severity severity);

struct Finding {
  Severity severity = Severity::kError;
  std::string what;
};

struct FileVerdict {
  std::string file;  // its name
  std::string kind;  // "MBTiles", "PMTiles", "GeoTIFF", ...
  std::vector<Finding> findings;
  // Of tiles, where it has such.
  std::optional<std::int64_t> tiles;
  int min_zoom = 0, max_zoom = 0, tile_size_px = 0;
  std::optional<geo::LatLonBounds> bounds;  // as the file itself says

  void Add(Severity severity, std::string what) { findings.push_back({severity, std::move(what)}); }
  bool Has(Severity severity) const;
};

// Findings that come once per tile.
class CountedFindings {
 public:
  void Add(Severity severity, const std::string& kind, const std::string& example);
  void MoveTo(FileVerdict& verdict);

 private:
  struct Counted {
    std::int64_t count = 0;
    std::vector<std::string> first;
  };
  std::map<std::pair<Severity, std::string>, Counted> counted_;
};

// `quick`: look into a sample of the pictures.
Result<std::vector<FileVerdict>> ValidateMap(const std::filesystem::path& path, bool quick,
                                             Progress& progress);

// Of one file each; what they cannot even open is a finding too. Error: kCancelled.
Result<FileVerdict> ValidateMbtiles(const std::filesystem::path& path, bool quick, Progress& progress);
Result<FileVerdict> ValidatePmtiles(const std::filesystem::path& path, bool quick, Progress& progress);
Result<FileVerdict> ValidateGeotiff(const std::filesystem::path& path, bool quick, Progress& progress);

// What report.json, photos.geojson and the like say, against each other and against what was found of tiles.
// None where there is no such file.
std::vector<FileVerdict> ValidateReports(const std::filesystem::path& folder,
                                         const std::vector<FileVerdict>& tiles);

}  // namespace skyquilt::storage
