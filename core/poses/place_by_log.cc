#include "core/poses/place_by_log.h"

#include <algorithm>
#include <cmath>

#include "core/base/try.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/evidence/recorded_series.h"
#include "core/poses/place_cameras.h"

namespace skyquilt::poses {
namespace {

// Measurements further from the photos than this say nothing about them.
constexpr double kLogMarginS = 60.0;

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
  part.imu = Part(log.imu, begin_s, end_s);
  part.attitude = Part(log.attitude, begin_s, end_s);
  part.gnss = Part(log.gnss, begin_s, end_s);
  part.baro = Part(log.baro, begin_s, end_s);
  part.range = Part(log.range, begin_s, end_s);
  part.gimbal = Part(log.gimbal, begin_s, end_s);
  return part;
}

}  // namespace

Result<PlacedByLog> PlaceByLog(const std::vector<PhotoAtTime>& photos, const flight::FlightLog& log,
                               const geo::LocalFrame& frame, const PlaceByLogOptions& options) {
  const bool has_positions =
      !log.gnss.empty() || std::any_of(photos.begin(), photos.end(),
                                       [](const PhotoAtTime& p) { return p.photo->position.has_value(); });
  const flight::FlightLog part = PartFor(log, photos.front().t_s, photos.back().t_s, has_positions);
  FlightSources sources;
  sources.photos = photos;
  sources.log = &part;
  sources.photo_clock_sigma_s = options.clock_sigma_s;
  sources.ended_at_start = options.landed_at_start;
  PreparedSmoothing prepared = MakeSmootherInput(sources, frame);
  SKYQUILT_TRY_ASSIGN(SmootherOutput smoothed, SmoothChain(prepared.input));
  const std::vector<PlacedCamera> cameras = PlaceCameras(prepared, smoothed, options.ground_z_in_enu_m);

  PlacedByLog placed;
  placed.is_placed = prepared.is_placed;
  placed.series = prepared.notes;
  placed.warnings = smoothed.report.warnings;
  placed.knots = smoothed.report.knots;
  placed.iterations = smoothed.report.iterations;
  for (std::size_t k = 0; k < cameras.size(); ++k) {
    PosedPhoto pose;
    pose.photo = *photos[k].photo;
    pose.cam_from_enu = cameras[k].cam_from_enu;
    pose.covariance = cameras[k].covariance;
    pose.covariance_with_next = cameras[k].covariance_with_next;
    pose.height_above_ground_m =
        cameras[k].cam_from_enu.TargetOriginInSource().z() - options.ground_z_in_enu_m;
    pose.error_radius_m = cameras[k].error_radius_m;
    pose.attitude_origin = cameras[k].attitude_origin;
    pose.velocity_in_enu_mps = cameras[k].velocity_in_enu_mps;
    if (!log.gnss.empty())
      pose.position_source = log.file_name;
    else if (pose.photo.position)
      pose.position_source = pose.photo.position->source;
    pose.clock_sigma_s = smoothed.border_sigma(kAtTauCamera);
    placed.photos.push_back(std::move(pose));
  }
  return placed;
}

}  // namespace skyquilt::poses
