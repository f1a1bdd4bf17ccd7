// FlightLog: what a flight recorder wrote, whatever its format, in SI units and one clock. Value of the
// parsers in this folder, input of core/poses. Any subset of the series may be empty. Times are seconds on
// the log's own clock (t_s), in rising order; utc_at_zero, when known, is the UTC instant of t_s = 0 (leap
// seconds applied).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::flight {

// Frame `body`: x forward, y right, z down. Specific force: at rest (0, 0, -9.81).
struct ImuSample {
  double t_s = 0.0;
  Eigen::Vector3d angular_rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();
};

struct AttitudeSample {
  double t_s = 0.0;
  Eigen::Quaterniond ned_from_body = Eigen::Quaterniond::Identity();
  bool has_yaw = true;
};

struct GnssSample : GnssHeights {
  double t_s = 0.0;
  geo::LatLon position;
  std::optional<Eigen::Vector3d> velocity_in_ned_mps;
  std::optional<double> sigma_horizontal_m;
  std::optional<double> sigma_vertical_m;
};

struct BaroSample {
  double t_s = 0.0;
  double height_above_takeoff_m = 0.0;
};

struct RangeSample {
  double t_s = 0.0;
  double distance_m = 0.0;  // along the body's down axis
};

// A place as the columns of a list give it, before any reading of them is believed: x stands for east or
// longitude, y for north or latitude, in the unit of the list's system.
struct WrittenPlace {
  double x = 0.0;
  double y = 0.0;
};

// One exposure as the recorder saw it.
struct CameraEvent : RecordedHeights {
  double t_s = 0.0;
  bool is_feedback = true;  // measured shutter; false: only the command to trigger
  std::optional<std::int64_t> sequence;
  std::optional<std::string> image_name;
  std::optional<WrittenPlace> written;  // of rows that name a photo, also where it can be no place as written
  std::optional<geo::LatLon> position;
  std::optional<double> system_error_m;  // as of RecordedPosition
  std::optional<Eigen::Vector3d> sigma_in_ned_m;
  // Horizon-zero angles of the camera or of the airframe, as `attitude_kind` says.
  std::optional<Eigen::Vector3d> yaw_pitch_roll_rad;
  AttitudeKind attitude_kind = AttitudeKind::kAirframe;
  bool yaw_is_from_grid_north = false;  // of omega, phi and kappa, where places count in a plane
  bool has_time = true;  // false: the format names the image only, and t_s is the number of the row
  std::optional<double> sigma_tilt_rad;
  std::optional<double> sigma_yaw_rad;
};

struct FlightLog {
  std::string format;  // "dataflash", "ulog", "mavlink_tlog", "dji_mrk", ...
  std::string file_name;
  std::vector<ImuSample> imu;
  std::vector<AttitudeSample> attitude;
  std::vector<GnssSample> gnss;
  std::vector<BaroSample> baro;
  std::vector<RangeSample> range;
  std::vector<CameraEvent> events;
  // The camera's own attitude where the recorder knows its gimbal: x along the optical axis, y image right, z
  // image down; at (yaw, pitch, roll) = 0 it looks north along the horizon, pitch -90 deg is straight down.
  std::vector<AttitudeSample> gimbal;
  std::optional<UtcTime> utc_at_zero;
  double utc_sigma_s = 0.0;
  // What a table's column of times counts at t_s = 0; two tables of one recorder may count alike.
  std::optional<double> counter_at_zero_s;
  std::optional<UtcTime> local_at_zero;   // a clock of unknown zone, where the format has no better one
  std::string written_system;             // of `written` in `events`, as PROJ knows it; empty: none is named
  bool written_order_is_named = false;    // a header says which column is which
  bool written_order_is_assumed = false;  // neither a header nor the format says it
  std::map<std::string, std::uint64_t> message_counts;  // by the format's own message names
  std::vector<std::string> mapping;                     // for tolerant formats: "column -> meaning, unit"
  std::vector<Remark> warnings;                         // damage, drop-outs, what was skipped and why
};

inline bool HasTimedEvents(const FlightLog& log) {
  return std::any_of(log.events.begin(), log.events.end(), [](const auto& e) { return e.has_time; });
}

// Calls `take` with each series of samples, but not with the events: of one log, or the same of several.
template <typename Take, typename... Logs>
void ForEachSeries(const Take& take, Logs&... logs) {
  take(logs.imu...);
  take(logs.attitude...);
  take(logs.gimbal...);
  take(logs.gnss...);
  take(logs.baro...);
  take(logs.range...);
}

}  // namespace skyquilt::flight
