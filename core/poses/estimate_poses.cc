#include "core/poses/estimate_poses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/poses/attitude_convention.h"
#include "core/poses/course.h"
#include "core/poses/flight_heights.h"

namespace skyquilt::poses {
namespace {

using flight::LeftOutPhoto;
using flight::Photo;

// One local frame serves a flight; further away its flat ground would leave the Earth.
constexpr double kFarthestFromFlightM = 20000.0;

struct AttitudeChoice {
  Eigen::Quaterniond cam_from_enu;
  AttitudeOrigin origin;
  double sigma_tilt_rad;
  double sigma_yaw_rad;
};

AttitudeChoice ChooseAttitude(const Photo& photo, const std::optional<double>& course_rad) {
  if (photo.attitude) {
    const bool is_gimbal = photo.attitude->kind == flight::AttitudeKind::kGimbal;
    return {CamFromEnu(*photo.attitude), AttitudeOrigin::kRecorded, geo::DegToRad(is_gimbal ? 1.0 : 2.0),
            geo::DegToRad(3.0)};
  }
  return {NadirCamFromEnu(course_rad.value_or(0.0)), AttitudeOrigin::kCourse, geo::DegToRad(5.0),
          course_rad ? geo::DegToRad(15.0) : geo::kPi};
}

Matrix6d PoseCovariance(const AttitudeChoice& attitude, double sigma_horizontal_m, double sigma_vertical_m) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance(0, 0) = covariance(1, 1) = attitude.sigma_tilt_rad * attitude.sigma_tilt_rad;
  covariance(2, 2) = attitude.sigma_yaw_rad * attitude.sigma_yaw_rad;
  covariance(3, 3) = covariance(4, 4) = sigma_horizontal_m * sigma_horizontal_m;
  covariance(5, 5) = sigma_vertical_m * sigma_vertical_m;
  return covariance;
}

geo::LatLon MedianPosition(const std::vector<Photo>& photos) {
  std::vector<double> lats;
  std::vector<double> lons;
  const double lon_zero = photos.front().position->position.lon_deg;
  for (const Photo& photo : photos) {
    lats.push_back(photo.position->position.lat_deg);
    // Relative to the first photo, so that a flight across the date line stays together.
    lons.push_back(std::remainder(photo.position->position.lon_deg - lon_zero, 360.0));
  }
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
  };
  return {median(lats), std::remainder(lon_zero + median(lons), 360.0)};
}

}  // namespace

Result<PosedFlight> EstimatePoses(const flight::Flight& flight, const EstimatePosesOptions& /*options*/,
                                  Progress& /*progress*/) {
  PosedFlight posed;
  posed.left_out = flight.left_out;
  posed.warnings = flight.warnings;

  std::vector<Photo> placeable;
  for (const Photo& photo : flight.photos) {
    if (photo.position) {
      placeable.push_back(photo);
    } else {
      posed.left_out.push_back({photo.name, ErrorCode::kNoPosition,
                                "has no position: no GPS in its EXIF or XMP and no log that covers it. Add the flight "
                                "log or a geo.txt with its position."});
    }
  }
  if (placeable.empty()) {
    return Error{ErrorCode::kUnprocessable,
                 "none of the files is a photo with a position, so there is nothing to place on the ground. Check that "
                 "the photos come straight from the drone (editing and messengers remove GPS data), or add the flight log.",
                 ""};
  }
  const FlightHeights heights = ChooseHeights(placeable);
  posed.height_rule = heights.rule;
  posed.warnings.insert(posed.warnings.end(), heights.warnings.begin(), heights.warnings.end());

  const geo::LatLon middle = MedianPosition(placeable);
  posed.frame = geo::LocalFrame({middle.lat_deg, middle.lon_deg, heights.takeoff_ellipsoid_m});
  posed.ground_z_in_enu_m = 0.0;

  std::vector<std::size_t> used;
  std::vector<Eigen::Vector3d> centers;
  for (std::size_t i = 0; i < placeable.size(); ++i) {
    const Photo& photo = placeable[i];
    if (!heights.above_ground_m[i]) {
      posed.left_out.push_back({photo.name, ErrorCode::kNoPosition,
                                "has no usable height above the ground, so its scale is unknown."});
      continue;
    }
    const Eigen::Vector3d center = posed.frame.EnuFromWgs84({photo.position->position.lat_deg,
                                                             photo.position->position.lon_deg,
                                                             heights.takeoff_ellipsoid_m + *heights.above_ground_m[i]});
    if (center.head<2>().norm() > kFarthestFromFlightM) {
      posed.left_out.push_back({photo.name, ErrorCode::kNoPosition,
                                fmt::format("was taken {:.0f} km away from the rest of the flight. If the position is right, "
                                            "stitch it as a flight of its own.", center.head<2>().norm() / 1000.0)});
      continue;
    }
    used.push_back(i);
    centers.push_back(center);
  }
  if (used.empty()) {
    return Error{ErrorCode::kUnprocessable, "no photo has a usable height above the ground", ""};
  }

  std::vector<Eigen::Vector2d> track;
  track.reserve(centers.size());
  for (const Eigen::Vector3d& center : centers) track.emplace_back(center.head<2>());
  const std::vector<std::optional<double>> courses = CoursesFromPositions(track);

  std::size_t without_attitude = 0;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const Photo& photo = placeable[used[k]];
    const AttitudeChoice attitude = ChooseAttitude(photo, courses[k]);
    if (attitude.origin != AttitudeOrigin::kRecorded) ++without_attitude;
    const double sigma_h = photo.position->sigma_horizontal_m.value_or(photo.position->is_rtk_fixed ? 0.03 : 1.5);
    const double sigma_v =
        photo.position->is_rtk_fixed ? photo.position->sigma_vertical_m.value_or(0.05) : heights.sigma_m;
    PosedPhoto pose;
    pose.photo = photo;
    pose.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(attitude.cam_from_enu, centers[k]);
    pose.covariance = PoseCovariance(attitude, sigma_h, sigma_v);
    pose.height_above_ground_m = centers[k].z() - posed.ground_z_in_enu_m;
    pose.error_radius_m = std::hypot(sigma_h, pose.height_above_ground_m * attitude.sigma_tilt_rad);
    pose.attitude_origin = attitude.origin;
    posed.photos.push_back(std::move(pose));
  }
  if (without_attitude > 0) {
    posed.warnings.push_back(fmt::format("{} of {} photos recorded no camera angles: they are taken as looking straight "
                                         "down, turned along the flight's course.",
                                         without_attitude, posed.photos.size()));
  }
  std::sort(posed.left_out.begin(), posed.left_out.end(),
            [](const LeftOutPhoto& a, const LeftOutPhoto& b) { return a.name < b.name; });
  return posed;
}

}  // namespace skyquilt::poses
