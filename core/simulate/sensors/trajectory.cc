#include "core/simulate/sensors/trajectory.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/try.h"
#include "core/geo/lat_lon.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr double kTurnS = 8.0;          // from the last photo of a line to the first of the next
constexpr double kWanderPhotos = 12.0;  // correlation of the height's wander, in photo intervals

Error Bad(const std::string& field, const std::string& value, const std::string& rule) {
  return Error{ErrorCode::kInvalidArgument,
               "The simulated flight's " + field + " is " + value + "; it must be " + rule + ".",
               "simulate options: " + field};
}

// Axes of the gimbal frame (x optical axis, y image right, z image down) in cam (x right, y down, z forward).
Eigen::Matrix3d CamFromGimbal() {
  Eigen::Matrix3d m;
  m << 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0;
  return m;
}

Eigen::Matrix3d NedFromEnu() {
  Eigen::Matrix3d m;
  m << 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0;
  return m;
}

}  // namespace

Result<void> TrajectoryOptions::Validate() const {
  if (photos < 1 || photos > 100000)
    return Bad("number of photos", std::to_string(photos), "from 1 to 100000");
  if (!(height_m >= 2.0 && height_m <= 5000.0))
    return Bad("height", std::to_string(height_m) + " m", "from 2 to 5000 m");
  if (!(front_overlap >= 0.0 && front_overlap <= 0.98)) {
    return Bad("front overlap", std::to_string(front_overlap), "from 0 to 0.98");
  }
  if (!(side_overlap >= 0.0 && side_overlap <= 0.98)) {
    return Bad("side overlap", std::to_string(side_overlap), "from 0 to 0.98");
  }
  if (!(speed_mps > 0.1 && speed_mps <= 60.0))
    return Bad("speed", std::to_string(speed_mps) + " m/s", "from 0.1 to 60 m/s");
  if (!(max_tilt_rad >= 0.0 && max_tilt_rad <= geo::DegToRad(45.0))) {
    return Bad("tilt", std::to_string(geo::RadToDeg(max_tilt_rad)) + " deg", "from 0 to 45 deg");
  }
  if (!std::isfinite(heading_rad)) return Bad("heading", "not a number", "an angle");
  if (photos_per_line < 0)
    return Bad("number of photos in a line", std::to_string(photos_per_line), "0 or more");
  if (!(position_jitter_m >= 0.0) || !(height_wander_m >= 0.0) || !(yaw_wander_rad >= 0.0)) {
    return Bad("jitter", "negative", "0 or more");
  }
  return {};
}

Eigen::Quaterniond CamFromEnuOfGimbal(const YawPitchRoll& gimbal) {
  const Eigen::Matrix3d ned_from_gimbal = (Eigen::AngleAxisd(gimbal.yaw_rad, Eigen::Vector3d::UnitZ()) *
                                           Eigen::AngleAxisd(gimbal.pitch_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(gimbal.roll_rad, Eigen::Vector3d::UnitX()))
                                              .toRotationMatrix();
  const Eigen::Matrix3d cam_from_enu = CamFromGimbal() * ned_from_gimbal.transpose() * NedFromEnu();
  return Eigen::Quaterniond(cam_from_enu).normalized();
}

YawPitchRoll GimbalOfCamFromEnu(const Eigen::Quaterniond& cam_from_enu) {
  const Eigen::Matrix3d ned_from_gimbal =
      NedFromEnu() * cam_from_enu.toRotationMatrix().transpose() * CamFromGimbal();
  YawPitchRoll gimbal;
  // The optical axis in NED gives yaw and pitch; near the vertical both come from its small horizontal part.
  const Eigen::Vector3d axis = ned_from_gimbal.col(0);
  const double sideways = std::hypot(axis.x(), axis.y());
  gimbal.pitch_rad = std::atan2(-axis.z(), sideways);
  if (sideways < 1e-9) {
    const Eigen::Vector3d right = ned_from_gimbal.col(1);
    gimbal.yaw_rad = std::atan2(-right.x(), right.y());
    return gimbal;
  }
  gimbal.yaw_rad = std::atan2(axis.y(), axis.x());
  gimbal.roll_rad = std::atan2(ned_from_gimbal(2, 1), ned_from_gimbal(2, 2));
  return gimbal;
}

Result<std::vector<TruePose>> PlanLawnmower(const TrajectoryOptions& options,
                                            const camera::Intrinsics& intrinsics) {
  SKYQUILT_TRY(options.Validate());
  const double across_m = options.height_m * intrinsics.width_px / intrinsics.focal_x_px;
  const double along_m = options.height_m * intrinsics.height_px / intrinsics.focal_y_px;
  const double step_m = (1.0 - options.front_overlap) * along_m;
  const double spacing_m = (1.0 - options.side_overlap) * across_m;
  int per_line = options.photos_per_line;
  if (per_line == 0) {
    per_line = static_cast<int>(std::lround(std::sqrt(options.photos * spacing_m / step_m)));
  }
  per_line = std::clamp(per_line, 1, options.photos);
  const int lines = (options.photos + per_line - 1) / per_line;

  RandomStream place(options.seed, 101);
  RandomStream turn(options.seed, 102);
  RandomStream wander(options.seed, 103);
  GaussMarkov height(options.height_wander_m, kWanderPhotos, wander);
  const Eigen::Vector2d ahead(std::sin(options.heading_rad), std::cos(options.heading_rad));
  const Eigen::Vector2d right(ahead.y(), -ahead.x());

  std::vector<TruePose> poses;
  poses.reserve(static_cast<std::size_t>(options.photos));
  double t_s = 0.0;
  for (int i = 0; i < options.photos; ++i) {
    const int line = i / per_line;
    const bool is_outbound = line % 2 == 0;
    const int in_line = is_outbound ? i % per_line : per_line - 1 - i % per_line;
    if (i > 0) t_s += i % per_line == 0 ? kTurnS : step_m / options.speed_mps;
    TruePose pose;
    pose.t_s = t_s;
    pose.line = line;
    pose.course_yaw_rad = geo::WrapRad(options.heading_rad + (is_outbound ? 0.0 : geo::kPi));
    const Eigen::Vector2d plan =
        (in_line - 0.5 * (per_line - 1)) * step_m * ahead + (line - 0.5 * (lines - 1)) * spacing_m * right;
    const Eigen::Vector3d center{plan.x() + options.position_jitter_m * place.Gauss(),
                                 plan.y() + options.position_jitter_m * place.Gauss(),
                                 options.height_m + height.Step(1.0, wander)};
    const Eigen::Vector2d velocity = (is_outbound ? options.speed_mps : -options.speed_mps) * ahead;
    pose.velocity_in_enu_mps = {velocity.x(), velocity.y(), 0.0};

    YawPitchRoll gimbal;
    gimbal.pitch_rad = -0.5 * geo::kPi;
    switch (options.yaw_rule) {
      case YawRule::kAlongCourse:
        gimbal.yaw_rad = pose.course_yaw_rad;
        break;
      case YawRule::kFixed:
        gimbal.yaw_rad = options.heading_rad;
        break;
      case YawRule::kAnywhere:
        gimbal.yaw_rad = turn.Uniform(-geo::kPi, geo::kPi);
        break;
    }
    gimbal.yaw_rad += options.yaw_wander_rad * turn.Gauss();
    const double lean = options.max_tilt_rad * std::sqrt(turn.Uniform());
    const double lean_way = turn.Uniform(-geo::kPi, geo::kPi);
    const Eigen::Quaterniond leaned_from_level(
        Eigen::AngleAxisd(lean, Eigen::Vector3d(std::cos(lean_way), std::sin(lean_way), 0.0)));
    pose.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        (leaned_from_level * CamFromEnuOfGimbal(gimbal)).normalized(), center);
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace skyquilt::simulate
