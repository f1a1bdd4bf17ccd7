// A FlightLog as the documented flight.csv: one row per sample, cells of other sensors empty. Pure; any
// thread.
#pragma once

#include <string>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::simulate {

std::string FlightCsv(const flight::FlightLog& log);

}  // namespace skyquilt::simulate
