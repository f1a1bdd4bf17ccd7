// GroundFromDem: how high the ground of an elevation model lies in a flight's enu frame, and below each
// photo. The model's own zero does not matter where heights count from take-off: there the ground below the
// first photo or at take-off is the flight's z = 0. Where heights are absolute, the model counts from sea
// level. Metres. Pure but for the model's reads; one thread per model.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "core/flight/remarks/remark.h"
#include "core/geo/dem_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

enum class DemZero { kTakeoff, kSeaLevel };

struct DemGround {
  double zero_m = 0.0;                                   // the model's height at z = 0 of the flight's frame
  std::vector<std::optional<double>> ground_z_in_enu_m;  // below each photo; nothing where the model has none
  double median_ground_z_in_enu_m = 0.0;
};

// takeoff: where it is known. Otherwise why not: the model does not cover the flight.
std::variant<DemGround, flight::RemarkCode> GroundFromDem(const geo::DemSource& dem, const PosedFlight& posed,
                                                          const std::optional<geo::LatLon>& takeoff,
                                                          DemZero zero);

}  // namespace skyquilt::poses
