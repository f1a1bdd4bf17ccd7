// ModelGroundReport: which surface the map is draped over, why, and how well it fits, for report.json.
// Heights in enu, metres. A value; any thread.
#pragma once

#include <optional>
#include <string>

namespace skyquilt::ground {

struct ModelGroundReport {
  std::string model;   // "plane", "grid" or "elevation model"
  std::string reason;  // why, in words
  int points_given = 0;
  int points_used = 0;
  double plane_error_m = 0.0;  // median height error of points held back, against the plane
  double grid_error_m = 0.0;   // and against the grid; 0 where none was tried
  std::optional<double>
      dem_error_m;  // and against the elevation model, moved up as a whole; nothing without one
  std::optional<double> dem_shift_m;  // how far up it was moved; nothing where it was not taken
  double cell_m = 0.0;
  double lowest_m = 0.0, highest_m = 0.0, mean_m = 0.0;  // in enu
  double seconds = 0.0;

  bool operator==(const ModelGroundReport&) const = default;
};

}  // namespace skyquilt::ground
