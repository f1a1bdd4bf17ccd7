// FindClockOffset: how far a camera's clock is from a log's where no events tell: by the offset at which the
// photos' own positions fit the log's track best, or from the two clocks as they stand. Constant-speed legs
// say nothing about time; turns, stops and changes of speed do, and the sigma shows it. Deterministic.
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/poses/time/stamped_photos.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::poses {

// Without the photos' times. `first`: the stamp from which the camera's stamps count. Error: kUnprocessable,
// with the reason, where the two cannot be tied.
Result<TimeSync> FindClockOffset(const std::vector<flight::Photo>& photos, const StampedPhotos& camera,
                                 flight::UtcTime first, const flight::FlightLog& log);

}  // namespace skyquilt::poses
