// SenseFlight: what the recorder of a simulated flight writes: every sensor's samples with its errors,
// generated from differences of the true path (never by integrating), as a FlightLog. A sample of an inertial
// unit is the mean over its interval and is stamped at the interval's middle. Deterministic in the seed; each
// sensor has its own stream of random numbers, so that switching one off leaves the others as they are. Any
// thread.
#pragma once

#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/simulate/sensors/flight_path.h"
#include "core/simulate/sensors/sensor_models.h"

namespace skyquilt::simulate {

// exposures_s: true times of exposure on the path's clock, rising. utc_at_zero: the UTC of the path's t = 0.
// Ground under the range finder is the plane z = 0.
flight::FlightLog SenseFlight(const FlightPath& path, const geo::LocalFrame& frame,
                              const std::vector<double>& exposures_s, flight::UtcTime utc_at_zero,
                              const SensorOptions& options);

}  // namespace skyquilt::simulate
