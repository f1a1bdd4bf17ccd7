// ReadCue: what one subtitle of a drone's film says of its place, heights, angles and clock, in the dialects
// of DJI and Autel: "GPS(lon,lat,satellites)", but "GPS(lat,lon,heightM)" where the third value carries an M,
// and "GPS(W: lon, N: lat, height)" where letters say which is which; "[latitude : x] [longtitude : y]";
// BAROMETER, Hb, H, ReH, rel_alt (above take-off), abs_alt, altitude (above mean sea level), in metres, or in
// feet where "ft" follows; F.PRY and G.PRY (pitch, roll, yaw in degrees), gb_yaw. HOME(...) is where the
// drone set out and no fix. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>

#include "core/flight/bytes/gps_time.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

struct CueFacts {
  std::optional<geo::LatLon> position;
  int decimals = 6;  // written of its degrees
  std::optional<double> height_amsl_m;
  std::optional<double> height_above_takeoff_m;
  std::optional<Eigen::Vector3d> airframe_yaw_pitch_roll_deg;
  std::optional<Eigen::Vector3d> gimbal_yaw_pitch_roll_deg;
};

CueFacts ReadCue(std::string_view text);

// The camera's clock: "2017.8.5 14:11:51", "2016-06-23 16:31:09,123,456".
std::optional<WrittenTime> CueDate(std::string_view text);

}  // namespace skyquilt::flight
