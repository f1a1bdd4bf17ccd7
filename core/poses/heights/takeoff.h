// FindTakeoff: where on Earth and how high a logged flight began, and how high the ground is that it looked
// at. The zero of the local frame. Order of trust for heights: barometer since take-off, range finder,
// photos' relative heights, the log's own beginning on the ground, and last a guess from the photos' spacing.
// Degrees, metres. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/lat_lon.h"
#include "core/poses/evidence/assumption.h"
#include "core/poses/evidence/recorded_series.h"

namespace skyquilt::poses {

struct Takeoff {
  std::optional<geo::LatLon> middle;    // of the photos, for the frame's origin; nothing without any position
  std::optional<geo::LatLon> position;  // where it took off, where the log begins there
  double height_ellipsoid_m = 0.0;      // of the frame's z = 0
  bool is_above_ellipsoid = false;      // that is known; else all heights count from the take-off
  bool hangs_on_cameras = false;  // that height follows from where the cameras are recorded to have been
  double ground_above_takeoff_m = 0.0;   // by the range finder, else zero
  std::string rule;                      // in words
  std::optional<Assumption> assumption;  // nothing: heights are recorded
};

// photos: times rising.
// given_ellipsoid_m: the height of the take-off, as the user says.
Takeoff FindTakeoff(const flight::FlightLog& log, const std::vector<PhotoAtTime>& photos,
                    const std::optional<double>& given_ellipsoid_m = {});

}  // namespace skyquilt::poses
