// A FlightLog as a PX4 ULog (.ulg) with the topics sensor_combined, vehicle_attitude, vehicle_gps_position,
// vehicle_air_data, distance_sensor, camera_capture and camera_trigger. Pure; any thread.
// Source: the ULog file format, docs.px4.io (version 1).
#pragma once

#include <cstdint>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::simulate {

std::vector<std::uint8_t> UlogBytes(const flight::FlightLog& log);

}  // namespace skyquilt::simulate
