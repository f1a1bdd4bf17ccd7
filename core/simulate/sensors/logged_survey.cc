#include "core/simulate/sensors/logged_survey.h"

#include <algorithm>
#include <cmath>

#include "core/base/try.h"
#include "core/geo/lat_lon.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr double kLowHoverM = 1.5;  // before and after the flight proper

struct Line {
  Eigen::Vector3d from, to;        // first and last photo
  std::vector<double> photo_at_m;  // along the line, from `from`
};

std::vector<Line> LinesOf(const std::vector<TruePose>& planned) {
  std::vector<Line> lines;
  int last = -1;
  for (const TruePose& pose : planned) {
    const Eigen::Vector3d center = pose.cam_from_enu.TargetOriginInSource();
    if (pose.line != last) lines.push_back({center, center, {}});
    last = pose.line;
    lines.back().to = center;
    lines.back().photo_at_m.push_back((center - lines.back().from).norm());
  }
  return lines;
}

// A line of one photo has no direction of its own: it takes the flight's.
Eigen::Vector3d WayOf(const Line& line, double heading_rad) {
  const Eigen::Vector3d way = line.to - line.from;
  if (way.norm() > 1e-6) return way.normalized();
  return {std::sin(heading_rad), std::cos(heading_rad), 0.0};
}

Eigen::Quaterniond CamFromBodyNadir() {
  Eigen::Matrix3d m;  // x right = body right, y down = body back, z forward = body down
  m << 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  return Eigen::Quaterniond(m);
}

TruePose PoseAt(const FlightPath& path, double t_s, int line, const SurveyOptions& options,
                RandomStream& random) {
  const PathState state = path.At(t_s);
  const double yaw_rad = NedYawPitchRoll(state.enu_from_body).x();
  const Eigen::Vector3d pointing{options.gimbal_tilt_rad * random.Gauss(),
                                 options.gimbal_tilt_rad * random.Gauss(),
                                 options.gimbal_tilt_rad * random.Gauss()};
  Eigen::Quaterniond cam_from_enu;
  if (options.mount == CameraMount::kFixedToBody) {
    cam_from_enu = CamFromBodyNadir() * state.enu_from_body.conjugate();
  } else {
    cam_from_enu = geo::RotationFromVector(pointing) * CamFromEnuOfGimbal({yaw_rad, -0.5 * geo::kPi, 0.0});
  }
  cam_from_enu.normalize();
  TruePose pose;
  pose.t_s = t_s;
  pose.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(cam_from_enu, state.point_in_enu);
  pose.velocity_in_enu_mps = state.velocity_in_enu_mps;
  pose.course_yaw_rad = yaw_rad;
  pose.line = line;
  return pose;
}

}  // namespace

Result<LoggedSurvey> FlySurvey(const SurveyOptions& options, const camera::Intrinsics& intrinsics,
                               const geo::LocalFrame& frame, flight::UtcTime utc_at_zero) {
  TrajectoryOptions plan = options.plan;
  plan.max_tilt_rad = plan.position_jitter_m = plan.height_wander_m = plan.yaw_wander_rad = 0.0;
  plan.yaw_rule = YawRule::kAlongCourse;
  SKYQUILT_TRY_ASSIGN(const auto planned, PlanLawnmower(plan, intrinsics));
  const std::vector<Line> lines = LinesOf(planned);

  PathOptions path_options;
  path_options.seed = plan.seed;
  path_options.start_yaw_rad = plan.heading_rad;
  path_options.still_before_s = options.still_before_s;
  path_options.gust_mps = options.gust_mps;
  path_options.gravity_mps2 = GravityMps2(frame.origin().lat_deg, frame.origin().height_ellipsoid_m);
  const auto add = [&path_options](const Eigen::Vector3d& point, double speed_mps, bool sets_yaw) {
    path_options.waypoints.push_back({point, speed_mps, 1.5, sets_yaw});
  };
  add({0.0, 0.0, kLowHoverM}, 1.0, false);
  add({0.0, 0.0, plan.height_m}, options.climb_mps, false);
  std::vector<std::size_t> line_waypoint;  // the waypoint that ends line i
  for (const Line& line : lines) {
    const Eigen::Vector3d way = WayOf(line, plan.heading_rad);
    add(line.from - options.run_in_m * way, plan.speed_mps, true);
    add(line.to + options.run_in_m * way, plan.speed_mps, true);
    line_waypoint.push_back(path_options.waypoints.size() - 1);
  }
  add({0.0, 0.0, plan.height_m}, plan.speed_mps, true);
  add({0.0, 0.0, kLowHoverM}, 2.0, false);
  add({0.0, 0.0, 0.0}, 0.5, false);
  FlightPath path = FlyPath(path_options);

  // The mission fires when the aircraft passes the planned place along the line.
  RandomStream random(plan.seed, 601);
  std::vector<TruePose> poses;
  std::vector<double> exposures_s;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Eigen::Vector3d way = WayOf(lines[i], plan.heading_rad);
    double t_s = path.arrivals_s()[line_waypoint[i] - 1];
    for (const double at_m : lines[i].photo_at_m) {
      while (t_s < path.EndS() && way.dot(path.At(t_s).point_in_enu - lines[i].from) < at_m) t_s += 0.01;
      const double exposure_s = t_s + options.sensors.events.delay_s;
      poses.push_back(PoseAt(path, exposure_s, static_cast<int>(i), options, random));
      exposures_s.push_back(exposure_s);
      t_s = std::max(t_s, exposure_s) + 0.2;
    }
  }
  SensorOptions sensors = options.sensors;
  sensors.seed = plan.seed;
  flight::FlightLog log = SenseFlight(path, frame, exposures_s, utc_at_zero, sensors);
  return LoggedSurvey{std::move(path), std::move(poses), std::move(log)};
}

}  // namespace skyquilt::simulate
