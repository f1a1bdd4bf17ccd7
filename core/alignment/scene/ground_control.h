// Ground control: surveyed points and where they were marked in photos. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::alignment {

struct ControlSighting {
  std::string photo_name;                                    // as the flight calls it
  Eigen::Vector2d pixel_in_image = Eigen::Vector2d::Zero();  // the middle of the first pixel is (0, 0)
};

struct ControlPoint {
  std::string list;  // the file that it is of
  std::string name;
  geo::LatLon position;
  std::optional<double> height_m;  // above any zero that all points share
  double sigma_horizontal_m = 0.02;
  double sigma_vertical_m = 0.04;
  std::optional<double>
      system_error_m;  // that all points of the list share, where their datum is not known well
  std::vector<ControlSighting> sightings;
};

// How far a mark lies from where its photo shows the surveyed point.
struct ControlMarkReport {
  std::string photo;  // as the flight calls it
  double residual_px = 0.0;
  double residual_m = 0.0;  // of that on the ground, straight down
  bool is_used = false;     // not contradicted by the point's other marks

  bool operator==(const ControlMarkReport&) const = default;
};

// How far off in height a point is whose height was compared with nothing; null in report.json.
inline constexpr double kNotComparedM = std::numeric_limits<double>::quiet_NaN();

// Where a map placed without a point, by the others alone, puts it: minus where it was surveyed.
struct ControlPrediction {
  double miss_east_m = 0.0, miss_north_m = 0.0, miss_up_m = kNotComparedM;

  bool operator==(const ControlPrediction&) const = default;
};
// The others must still hold the map.
inline constexpr std::size_t kMinPredictedPoints = 4;

// What became of one: adjusted minus surveyed.
struct ControlReport {
  std::string name;
  geo::LatLon surveyed;
  int sightings = 0;  // in photos of this flight
  bool is_used = false;
  bool is_check = false;                 // compared with the finished map alone
  std::optional<flight::Remark> reason;  // why it is not used, or not all of its marks
  double miss_east_m = 0.0, miss_north_m = 0.0, miss_up_m = kNotComparedM;
  double residual_px = 0.0;
  std::optional<double> system_error_m;       // as of ControlPoint
  std::optional<ControlPrediction> left_out;  // nothing: too few points, or not asked
  std::vector<ControlMarkReport> marks;       // once the map has its place

  bool operator==(const ControlReport&) const = default;
};

}  // namespace skyquilt::alignment
