#include "core/poses/place_by_records.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/median.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/conventions/choose_convention.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/plausible_poses.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;

// One local frame serves a flight; further away its flat ground would leave the Earth.
constexpr double kFarthestFromFlightM = 20000.0;

struct AttitudeChoice {
  Eigen::Quaterniond cam_from_enu;
  AttitudeOrigin origin;
  double sigma_tilt_rad;
  double sigma_yaw_rad;
};

// `direction`: where it is to be believed.
AttitudeChoice ChooseAttitude(const Photo& photo, const std::optional<double>& course_rad,
                              const std::optional<flight::RecordedDirection>& direction) {
  if (photo.attitude) {
    const bool is_gimbal = photo.attitude->kind == flight::AttitudeKind::kGimbal;
    return {CamFromEnu(*photo.attitude), AttitudeOrigin::kRecorded, geo::DegToRad(is_gimbal ? 1.0 : 2.0),
            geo::DegToRad(3.0)};
  }
  constexpr double kLeanDeg = 5.0;
  if (direction) {
    // What compasses of phones, and beside motors, err by; the unknown declination adds to it.
    const double sigma_deg = direction->is_from_true_north ? 15.0 : 25.0;
    return {NadirCamFromEnu(direction->yaw_rad), AttitudeOrigin::kDirection, geo::DegToRad(kLeanDeg),
            geo::DegToRad(sigma_deg)};
  }
  return {NadirCamFromEnu(course_rad.value_or(0.0)), AttitudeOrigin::kCourse, geo::DegToRad(kLeanDeg),
          course_rad ? geo::DegToRad(15.0) : geo::kPi};
}

// Whether the photos of which nothing else says how they are turned have directions that are measured: a
// device that does not know them writes one for all.
bool AreMeasured(const std::vector<Photo>& photos, const std::vector<std::size_t>& used) {
  std::vector<double> yaws_rad;
  for (const std::size_t i : used) {
    if (photos[i].direction && !photos[i].attitude) yaws_rad.push_back(photos[i].direction->yaw_rad);
  }
  return yaws_rad.size() == 1 || std::any_of(yaws_rad.begin(), yaws_rad.end(),
                                             [&](double yaw_rad) { return yaw_rad != yaws_rad.front(); });
}

// So far from those before and after it that they share no ground: what turned it no picture shows, and where
// the aircraft went in between says little.
bool StandsApart(const camera::Intrinsics& lens, const std::vector<Eigen::Vector3d>& centers, std::size_t k) {
  const double across_m = centers[k].z() * std::hypot(lens.width_px, lens.height_px) / lens.MeanFocalPx();
  const auto is_far = [&](std::size_t other) {
    return (centers[other] - centers[k]).head<2>().norm() > across_m;
  };
  return (k == 0 || is_far(k - 1)) && (k + 1 == centers.size() || is_far(k + 1));
}

Matrix6d PoseCovariance(const AttitudeChoice& attitude, double sigma_horizontal_m, double sigma_vertical_m) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance(0, 0) = covariance(1, 1) = attitude.sigma_tilt_rad * attitude.sigma_tilt_rad;
  covariance(2, 2) = attitude.sigma_yaw_rad * attitude.sigma_yaw_rad;
  covariance(3, 3) = covariance(4, 4) = sigma_horizontal_m * sigma_horizontal_m;
  covariance(5, 5) = sigma_vertical_m * sigma_vertical_m;
  return covariance;
}

// Receivers, compasses and barometers err slowly: two photos seconds apart err together, and their difference
// is far better known than either. Only what they do not share is their own.
void RelateToNext(PosedPhoto& here, const PosedPhoto& next) {
  if (!here.photo.captured_at || !next.photo.captured_at) return;
  constexpr double kPositionTimeS = 120.0, kAngleTimeS = 40.0;
  constexpr double kPositionWhiteM = 0.15, kAngleWhiteRad = 0.0035;
  const double apart_s = std::abs(flight::SecondsBetween(*here.photo.captured_at, *next.photo.captured_at));
  for (int i = 0; i < 6; ++i) {
    const double white =
        i < 3 ? kAngleWhiteRad : std::min(kPositionWhiteM, 0.5 * std::sqrt(here.covariance(i, i)));
    const auto slow = [&](const PosedPhoto& photo) {
      return std::max(0.0, photo.covariance(i, i) - white * white);
    };
    here.covariance_with_next(i, i) =
        std::sqrt(slow(here) * slow(next)) * std::exp(-apart_s / (i < 3 ? kAngleTimeS : kPositionTimeS));
  }
}

// By which what positions state is multiplied, so that half of them state no more than receivers err apart.
// Positions that were moved on from a fix of before are off by the way flown, each by itself.
double ShareErredApart(const std::vector<Photo>& photos, const std::vector<std::size_t>& used) {
  std::vector<double> stated_m;
  for (const std::size_t i : used) {
    if (!photos[i].position->is_repeated) stated_m.push_back(SigmaOfRecordM(*photos[i].position));
  }
  return std::min(1.0, kWorstPlainM / MedianIfAny(std::move(stated_m)).value_or(kWorstPlainM));
}

}  // namespace

PlacedByRecords PlaceByRecords(const std::vector<Photo>& photos, const FlightHeights& heights,
                               const geo::LocalFrame& frame) {
  PlacedByRecords placed;
  std::vector<std::size_t> used;
  std::vector<Eigen::Vector3d> centers;
  std::vector<Eigen::Vector2d> track;
  std::vector<std::string_view> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const Photo& photo = photos[i];
    const auto leave_out = [&](flight::Remark reason) {
      placed.left_out.push_back({photo.name, ErrorCode::kNoPosition, std::move(reason)});
      // No picture brings a flight back from where web maps end.
      if (std::abs(photo.position->position.lat_deg) <= kHighestLatDeg) placed.unplaced.push_back(photo);
    };
    if (!heights.above_ground_m[i]) {
      leave_out(flight::RemarkCode::kLeftWithoutHeight);
      placed.any_without_height = true;
      continue;
    }
    const geo::LatLon& at = photo.position->position;
    const Eigen::Vector3d center = frame.EnuFromWgs84(
        {at.lat_deg, at.lon_deg, frame.origin().height_ellipsoid_m + *heights.above_ground_m[i]});
    if (center.head<2>().norm() > kFarthestFromFlightM) {
      leave_out({flight::RemarkCode::kLeftFarFromFlight, {{"apart_km", center.head<2>().norm() / 1000.0}}});
      continue;
    }
    used.push_back(i);
    centers.push_back(center);
    track.emplace_back(center.head<2>());
    cameras.emplace_back(photo.camera_key);
  }
  const std::vector<std::optional<double>> courses = CoursesOfCameras(cameras, track);
  const double share_apart = ShareErredApart(photos, used);
  const bool are_measured = AreMeasured(photos, used);
  for (std::size_t k = 0; k < used.size(); ++k) {
    const Photo& photo = photos[used[k]];
    const bool is_by_direction = are_measured && (!courses[k] || StandsApart(photo.intrinsics, centers, k));
    const AttitudeChoice attitude =
        ChooseAttitude(photo, courses[k], is_by_direction ? photo.direction : std::nullopt);
    if (attitude.origin != AttitudeOrigin::kRecorded) ++placed.without_angles;
    if (attitude.origin == AttitudeOrigin::kDirection) ++placed.by_direction;
    const flight::RecordedPosition& position = *photo.position;
    const double sigma_h = SigmaOfRecordM(position);
    const bool is_height_surveyed = position.is_rtk_fixed && position.height_ellipsoid_m;
    const double sigma_v = is_height_surveyed ? position.sigma_vertical_m.value_or(0.05) : heights.sigma_m;
    PosedPhoto pose;
    pose.photo = photo;
    pose.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(attitude.cam_from_enu, centers[k]);
    pose.covariance =
        PoseCovariance(attitude, position.is_repeated ? sigma_h : share_apart * sigma_h, sigma_v);
    pose.height_above_ground_m = centers[k].z();
    pose.error_radius_m = std::hypot(sigma_h, pose.height_above_ground_m * attitude.sigma_tilt_rad);
    pose.attitude_origin = attitude.origin;
    pose.position_source = position.source;
    pose.velocity_in_enu_mps = photo.velocity_in_enu_mps;
    placed.photos.push_back(std::move(pose));
  }
  for (std::size_t k = 0; k + 1 < placed.photos.size(); ++k)
    RelateToNext(placed.photos[k], placed.photos[k + 1]);
  return placed;
}

}  // namespace skyquilt::poses
