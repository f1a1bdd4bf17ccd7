// Coordinates of side files in any reference system, brought to WGS84. The line that names the system is what
// ODM accepts: "EPSG:32616", "WGS84 UTM 16N", "EPSG:4326" or "WGS84" for longitude and latitude, "+proj=..."
// strings. Through PROJ; strings that name grid files or pipelines are refused. One object a thread.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/log_bytes.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

class ReferenceSystem {
 public:
  // Errors: kUnsupportedFormat for a line that names no system PROJ knows.
  static Result<ReferenceSystem> Parse(std::string_view line);
  ReferenceSystem(ReferenceSystem&&) noexcept;
  ReferenceSystem& operator=(ReferenceSystem&&) noexcept;
  ~ReferenceSystem();

  // x is east or longitude, y north or latitude, in the unit of the system. Error: kUnprocessable outside its
  // area.
  Result<geo::LatLon> ToLatLon(double x, double y) const;
  // Metres per unit of the horizontal axes (1 for degrees): heights of such files are in the same unit.
  double metres_per_unit() const;
  const std::string& name() const;

 private:
  struct Impl;
  explicit ReferenceSystem(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// True for a line that looks like the first line of an ODM side file, without asking PROJ.
bool LooksLikeReferenceSystem(std::string_view line);

// The words of the first row below such a line; lines starting with # are comments. Empty where `head` is no
// text, has no such line, or no row.
std::vector<std::string_view> FirstReferencedRow(LogBytes head);

}  // namespace skyquilt::flight
