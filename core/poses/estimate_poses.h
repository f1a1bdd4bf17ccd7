// EstimatePoses: from what was recorded to one pose and covariance per photo in the flight's local frame.
// With a log the photos are tied to its clock and placed by the smoothed chain of all its series; without
// one, or outside its time, by what they say of themselves. Without any position the flight is reckoned from
// its start, which lies at the given origin. Photos that cannot be placed are listed in left_out with the
// reason. The result does not depend on threads. Errors: kUnprocessable when no photo can be placed.
#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/flight/flight.h"
#include "core/geo/dem_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

struct EstimatePosesOptions {
  std::optional<geo::LatLon> origin;    // where a flight without positions starts
  bool landed_at_start = false;         // it came back there (only asked without positions)
  const geo::DemSource* dem = nullptr;  // heights of the ground, where known
  // Photos without usable position or height are handed on as PosedFlight::unplaced, and a flight of nothing
  // else is no error: its frame lies at surveyed points, at the given origin or nowhere (is_placed is false).
  bool keep_unplaced = false;
  // Of the place of take-off, above sea level; counts instead of what is recorded of it.
  std::optional<double> takeoff_height_amsl_m = {};
};

Result<PosedFlight> EstimatePoses(const flight::Flight& flight, const EstimatePosesOptions& options);

}  // namespace skyquilt::poses
