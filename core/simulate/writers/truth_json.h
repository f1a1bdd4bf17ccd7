// poses.json: the truth about every photo of a simulated flight, for tests and for people. Pure; any thread.
#pragma once

#include <string>

#include "core/simulate/simulate_flight.h"

namespace skyquilt::simulate {

std::string TruthJson(const SimulatedFlight& flight);

}  // namespace skyquilt::simulate
