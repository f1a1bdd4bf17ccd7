// EstimatePoses: from what was recorded to one pose and covariance per photo in the flight's local frame.
// Photos without a usable position are listed in left_out with the reason. The result does not depend on threads.
// Errors: kUnprocessable when no photo has a position.
#pragma once

#include <optional>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/flight.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

struct EstimatePosesOptions {
  std::optional<geo::LatLon> origin;  // where a flight without positions starts
};

Result<PosedFlight> EstimatePoses(const flight::Flight& flight, const EstimatePosesOptions& options,
                                  Progress& progress);

}  // namespace skyquilt::poses
