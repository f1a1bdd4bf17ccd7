// Where the flat ground lies under posed photos, and how high each of them is above it: by an elevation model
// (PutGroundByDem), and by the photos' spacing where they would stand on the ground or below it
// (PutGroundBelow). Changes the flight's ground, heights, warnings and report. Frame enu of the flight,
// metres. Pure but for the model's reads; one thread per model.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/geo/dem_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

// What the flight's heights count from. The model's own zero does not matter where that is take-off: there
// the ground at take-off, or below the first photo, is z = 0. Where heights are absolute, the model counts
// from sea level.
enum class DemZero { kTakeoff, kSeaLevel };

// takeoff: where it is known. A model that does not cover the flight changes nothing, and a warning says so.
void PutGroundByDem(const geo::DemSource& dem, const std::optional<geo::LatLon>& takeoff, DemZero zero,
                    PosedFlight& posed);
// How many of the photos that are left lie where a model that was taken has no height.
void TellGapsOfDem(PosedFlight& posed);

// Photos that mostly stand on or below the ground say that it was put at the wrong height: take-off on a
// hill, or heights that count from another zero. Their spacing is then the better measure.
void PutGroundBelow(PosedFlight& posed);

// Without the geoid at the flight (`geoid_m`) heights above the sea count as above the ellipsoid, which is
// said; what the flight's heights count from is not known then. `log`: null where none places photos.
// `is_zero_of_sea`: the take-off's height is given, or an elevation model's.
void TellLackOfGeoid(const std::optional<double>& geoid_m, const std::vector<flight::Photo>& photos,
                     const flight::FlightLog* log, bool is_zero_of_sea, PosedFlight& posed);

}  // namespace skyquilt::poses
