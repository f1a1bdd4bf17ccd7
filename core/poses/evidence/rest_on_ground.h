// Whether a stillness of the inertial sensors was rest on the ground, by the barometer. Heights over take-off
// in enu, times of the log's clock, both rising. Pure functions; any thread.
#pragma once

#include <vector>

#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

// A steady climb and a calm hover feel like rest to inertial sensors; only rest on the ground is rest.
bool IsAloft(const std::vector<HeightFix>& heights, const StillInterval& interval);

// The part of a rest in which the aircraft also stayed at its height: a slow, even descent onto the ground is
// still flight. The reference is the side away from the flight.
StillInterval AtOneHeight(const std::vector<HeightFix>& heights, StillInterval interval, bool flight_follows);

}  // namespace skyquilt::poses
