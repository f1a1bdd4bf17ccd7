// FileVerdict: what was found wrong, doubtful or worth saying of one file of a map, in sentences for a
// person. What is the same of many tiles is said once, with how many and the first of them. One thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::storage {

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

}  // namespace skyquilt::storage
