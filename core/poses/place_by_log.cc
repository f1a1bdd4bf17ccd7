#include "core/poses/place_by_log.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/try.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/smoother/chain_factors.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// Where the optical axis meets the ground plane, by the pose's small errors; for the error radius.
double CenterErrorM(const PosedPhoto& camera, double ground_z) {
  const Quaterniond enu_from_cam = camera.cam_from_enu.rotation.conjugate();
  const Vector3d center = camera.cam_from_enu.TargetOriginInSource();
  const Vector3d axis = enu_from_cam * Vector3d::UnitZ();
  const double along = (ground_z - center.z()) / std::min(axis.z(), -0.1);
  const Vector3d ray = along * axis;
  // Position moves the point as is, a turn by turn x ray; both then slide along the axis to the plane.
  Matrix3d to_plane = Matrix3d::Identity();
  to_plane.col(2) -= axis / std::min(axis.z(), -0.1);
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose << -Skew(ray), Matrix3d::Identity();
  const Eigen::Matrix<double, 2, 6> on_ground = (to_plane * by_pose).topRows<2>();
  const double trace = (on_ground * camera.covariance * on_ground.transpose()).trace();
  return std::sqrt(std::max(0.0, trace));
}

}  // namespace

std::vector<PosedPhoto> PlaceCameras(const PreparedSmoothing& prepared, const SmootherOutput& smoothed,
                                     double ground_z_in_enu_m) {
  constexpr double kGimbalWhiteRad = 0.005;  // the gimbal's own jitter about the airframe's attitude
  std::vector<PosedPhoto> cameras;
  for (std::size_t k = 0; k < smoothed.poses.size(); ++k) {
    const SmoothedPose& pose = smoothed.poses[k];
    PosedPhoto camera;
    camera.covariance = pose.covariance;
    camera.covariance_with_next = pose.covariance_with_next;
    const Vector3d& v = pose.velocity_in_enu_mps;
    camera.covariance.bottomRightCorner<3, 3>() += std::pow(prepared.time_sigma_s[k], 2) * v * v.transpose();
    camera.velocity_in_enu_mps = pose.velocity_in_enu_mps;
    camera.attitude_origin = prepared.attitude_origins[k];
    Quaterniond enu_from_cam = pose.enu_from_body * prepared.cam_from_body[k].conjugate();
    if (const std::optional<Quaterniond>& recorded = prepared.recorded_enu_from_cam[k]) {
      // Measured airframe = Exp(level axes * bias) R: attitude system and gimbal are turned by that.
      const Vector3d turned = LevelAxes(pose.enu_from_body) * pose.attitude_bias_rad;
      enu_from_cam = geo::RotationFromVector(-turned) * *recorded;
      camera.covariance.topLeftCorner<3, 3>().diagonal().array() += kGimbalWhiteRad * kGimbalWhiteRad;
    }
    camera.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(enu_from_cam.normalized().conjugate(),
                                                                   pose.position_in_enu_m);
    camera.height_above_ground_m = camera.cam_from_enu.TargetOriginInSource().z() - ground_z_in_enu_m;
    camera.error_radius_m = CenterErrorM(camera, ground_z_in_enu_m);
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

namespace {

// Measurements further from the photos than this say nothing about them.
constexpr double kLogMarginS = 60.0;
// After a longer pause no sensor errs as it did before: a chain of its own. Through the nights of a survey of
// some days one chain took gigabytes, or more knots than there may be.
constexpr double kLongestPauseS = 1800.0;

template <typename Sample>
std::vector<Sample> Part(const std::vector<Sample>& samples, double begin_s, double end_s) {
  const auto before = [](const Sample& sample, double t_s) { return sample.t_s < t_s; };
  const auto from = std::lower_bound(samples.begin(), samples.end(), begin_s, before);
  return {from, std::lower_bound(from, samples.end(), end_s, before)};
}

// The part of a log that the photos need; all of it where the flight is reckoned from its start.
flight::FlightLog PartFor(const flight::FlightLog& log, double first_s, double last_s, bool has_positions) {
  const double begin_s = has_positions ? first_s - kLogMarginS : -1e18;
  const double end_s = has_positions ? last_s + kLogMarginS : 1e18;
  flight::FlightLog part;
  part.format = log.format;
  part.file_name = log.file_name;
  flight::ForEachSeries([&](auto& of_part, const auto& all) { of_part = Part(all, begin_s, end_s); }, part,
                        log);
  return part;
}

bool HavePositions(const std::vector<flight::GnssSample>& fixes, const std::vector<PhotoAtTime>& photos) {
  return !fixes.empty() || std::any_of(photos.begin(), photos.end(),
                                       [](const PhotoAtTime& p) { return p.photo->position.has_value(); });
}

// Between long pauses; in one where a part would have no position.
std::vector<FlightSources> PartsOf(const FlightSources& whole) {
  std::vector<FlightSources> parts;
  FlightSources of_none = whole;
  of_none.photos.clear();
  for (const PhotoAtTime& photo : whole.photos) {
    if (parts.empty() || photo.t_s - parts.back().photos.back().t_s > kLongestPauseS)
      parts.push_back(of_none);
    parts.back().photos.push_back(photo);
  }
  const bool have_all_positions = std::all_of(parts.begin(), parts.end(), [](const FlightSources& part) {
    const double begin_s = part.photos.front().t_s, end_s = part.photos.back().t_s;
    return HavePositions(Part(part.log->gnss, begin_s - kLogMarginS, end_s + kLogMarginS), part.photos);
  });
  if (!have_all_positions) return {whole};
  return parts;
}

// `since_first_s`: after the first photo of all parts.
Result<PlacedByLog> PlacePart(FlightSources sources, bool has_positions, double since_first_s,
                              const geo::LocalFrame& frame, double ground_z_in_enu_m) {
  const std::vector<PhotoAtTime>& photos = sources.photos;
  const flight::FlightLog& log = *sources.log;
  const flight::FlightLog part = PartFor(log, photos.front().t_s, photos.back().t_s, has_positions);
  sources.log = &part;
  PreparedSmoothing prepared = MakeSmootherInput(sources, frame);
  SmootherOptions& options = prepared.input.options;
  if (since_first_s > 0.0) {
    options.baro_bias_first_sigma_m =
        std::hypot(options.baro_bias_first_sigma_m, options.baro_bias_walk * std::sqrt(since_first_s));
  }
  SKYQUILT_TRY_ASSIGN(SmootherOutput smoothed, SmoothChain(prepared.input));
  PlacedByLog placed;
  placed.photos = PlaceCameras(prepared, smoothed, ground_z_in_enu_m);
  placed.is_placed = prepared.is_placed;
  placed.series = prepared.notes;
  placed.smoothing = std::move(smoothed.report);
  for (std::size_t k = 0; k < placed.photos.size(); ++k) {
    PosedPhoto& pose = placed.photos[k];
    pose.photo = *photos[k].photo;
    if (!part.gnss.empty())
      pose.position_source = log.file_name;
    else if (pose.photo.position)
      pose.position_source = pose.photo.position->source;
    pose.clock_sigma_s = smoothed.border_sigma(kAtTauCamera);
  }
  return placed;
}

void AddNew(std::vector<std::string> more, std::vector<std::string>& all) {
  for (std::string& one : more) {
    if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(std::move(one));
  }
}

}  // namespace

Result<PlacedByLog> PlaceByLog(const FlightSources& whole, const geo::LocalFrame& frame,
                               double ground_z_in_enu_m) {
  const bool has_positions = HavePositions(whole.log->gnss, whole.photos);
  PlacedByLog placed;
  for (FlightSources& sources : PartsOf(whole)) {
    const double since_first_s = sources.photos.front().t_s - whole.photos.front().t_s;
    SKYQUILT_TRY_ASSIGN(PlacedByLog part, PlacePart(std::move(sources), has_positions, since_first_s, frame,
                                                    ground_z_in_enu_m));
    placed.is_placed = placed.is_placed && part.is_placed;
    std::move(part.photos.begin(), part.photos.end(), std::back_inserter(placed.photos));
    AddNew(std::move(part.series), placed.series);
    placed.smoothing.knots += part.smoothing.knots;
    placed.smoothing.iterations = std::max(placed.smoothing.iterations, part.smoothing.iterations);
    AddNew(std::move(part.smoothing.warnings), placed.smoothing.warnings);
  }
  return placed;
}

}  // namespace skyquilt::poses
