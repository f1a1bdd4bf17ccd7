// MakeSmootherInput: from what was recorded to the smoother: gathers the series of a log and of the photos in
// the flight's local frame, with sigmas, and says which it took; place_by_log.h goes the way back. Without a
// log the photos themselves are the series (XMP or EXIF: position, camera angles, relative height), and the
// body is a level one that turns with the camera. With a log the body is the airframe; a gimbal keeps its own
// recorded angles and shares the airframe's slow attitude error. Frames: `enu` of the given LocalFrame,
// `body`, `cam`; the log's clock, seconds. Pure; any thread.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/poses/evidence/recorded_series.h"
#include "core/poses/posed_flight.h"
#include "core/poses/smoother/smoother.h"

namespace skyquilt::poses {

struct FlightSources {
  std::vector<PhotoAtTime> photos;         // times rising
  const flight::FlightLog* log = nullptr;  // may be absent
  double photo_clock_sigma_s = 0.0;        // of all photo times together against the log
  // Without any position: where the flight started (in enu), and whether it came back there.
  Eigen::Vector3d start_in_enu_m = Eigen::Vector3d::Zero();
  bool ended_at_start = false;
};

struct PreparedSmoothing {
  SmootherInput input;
  // One per photo: the camera in the body that the smoother estimates.
  std::vector<Eigen::Quaterniond> cam_from_body;
  // One per photo: the camera's own recorded rotation where a gimbal holds it apart from the airframe.
  std::vector<std::optional<Eigen::Quaterniond>> recorded_enu_from_cam;
  std::vector<AttitudeOrigin> attitude_origins;
  std::vector<double> time_sigma_s;  // one per photo: of its time alone
  bool is_placed = true;             // false: nothing says where on Earth the flight was
  std::vector<std::string> notes;    // which series were taken, in words
};

PreparedSmoothing MakeSmootherInput(const FlightSources& sources, const geo::LocalFrame& frame);

}  // namespace skyquilt::poses
