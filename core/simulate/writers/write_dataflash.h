// A FlightLog as an ArduPilot DataFlash log (.BIN): self-describing messages IMU, ATT, GPS, GPA, BARO, RFND,
// TRIG, CAM. Loses what the format cannot hold: positions are rounded to 1e-7 degrees, angles to 0.01
// degrees, heights to 1 cm over the sea. Pure; any thread. Source: the layout strings of ArduPilot's
// LogStructure.h, as documented at ardupilot.org (Logmessages).
#pragma once

#include <cstdint>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::simulate {

std::vector<std::uint8_t> DataflashBytes(const flight::FlightLog& log);

}  // namespace skyquilt::simulate
