// A survey flown by the simulated multirotor with its recorder running: the true path, the true camera poses
// at the exposures, and the log. The camera is fixed to the body (nadir, image top forward) or hangs in a
// gimbal. Deterministic in the seed. Values; any thread.
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/camera/intrinsics.h"
#include "core/flight/logs/flight_log.h"
#include "core/geo/local_frame.h"
#include "core/simulate/sensors/flight_path.h"
#include "core/simulate/sensors/sensors.h"
#include "core/simulate/sensors/trajectory.h"

namespace skyquilt::simulate {

enum class CameraMount { kFixedToBody, kGimbal };

struct SurveyOptions {
  TrajectoryOptions plan;  // lines, overlaps, height, speed (its tilt and jitter do not apply)
  CameraMount mount = CameraMount::kFixedToBody;
  double gimbal_tilt_rad = 0.003;  // 1-sigma of a gimbal's pointing
  double still_before_s = 9.0;
  double climb_mps = 2.5;
  double run_in_m = 10.0;  // flown before the first and after the last photo of a line
  double gust_mps = 0.3;
  SensorOptions sensors;  // its seed is replaced by the plan's
};

struct LoggedSurvey {
  FlightPath path;
  std::vector<TruePose> poses;  // t_s on the log's clock
  flight::FlightLog log;
};

Result<LoggedSurvey> FlySurvey(const SurveyOptions& options, const camera::Intrinsics& intrinsics,
                               const geo::LocalFrame& frame, flight::UtcTime utc_at_zero);

}  // namespace skyquilt::simulate
