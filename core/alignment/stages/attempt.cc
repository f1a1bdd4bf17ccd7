#include "core/alignment/stages/attempt.h"

#include <algorithm>
#include <utility>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/scene/tracks.h"
#include "core/base/median.h"
#include "core/base/process/large_blocks_apart.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr double kReliefCellGsds = 60.0;
constexpr double kGroundSigmas = 3.0;        // largest error of an observation of a point on the ground
constexpr double kResidualWidthPx = 4000.0;  // of a photo, that residuals are told for

constexpr std::size_t kManyPhotos = 500;

double ResidualAtWidth(double rms_px, const poses::PosedFlight& posed) {
  if (posed.photos.empty()) return 0.0;
  std::vector<double> widths;
  for (const poses::PosedPhoto& photo : posed.photos) widths.push_back(photo.photo.intrinsics.width_px);
  return rms_px * kResidualWidthPx / Median(std::move(widths));
}

std::vector<Eigen::Vector3d> ReliefPoints(const std::vector<Track>& tracks) {
  constexpr double kUsefulAngleRad = 0.06;
  std::vector<Eigen::Vector3d> points;
  for (const Track& track : tracks) {
    if (track.angle_rad > kUsefulAngleRad) points.push_back(track.point_in_enu);
  }
  return points;
}

}  // namespace

WeighedAttempt AsWeighed(const ExtractedFlight& extracted, const Attempt& attempt) {
  return {&extracted.records,
          &extracted.readable,
          &attempt.matched.links,
          &attempt.problem,
          ResidualAtWidth(attempt.adjusted.rms_px, attempt.posed),
          attempt.adjusted.observations,
          attempt.adjusted.dropped,
          attempt.is_adjusted};
}

Attempt Adjusted(Attempt attempt, const BundleOptions& bundle_options, const AlignOptions& options) {
  if (attempt.input.views.size() >= kManyPhotos) ReturnFreedMemory();  // the matcher's, before the solver's
  TrackOptions track_options;
  track_options.observations_per_photo = options.observations_per_photo;
  {
    ScopedTimer timer(attempt.adjustment_s);
    attempt.problem.tracks = {};  // not both at a time
    attempt.problem.tracks =
        BuildTracks(attempt.matched.links, attempt.input.features, attempt.input.views, track_options);
    std::erase_if(attempt.problem.tracks,
                  [&](Track& track) { return !Triangulate(attempt.input.views, track); });
    attempt.adjusted = AdjustBundle(attempt.problem, bundle_options);
  }
  TraceDecision("adjusted", {{"points", attempt.problem.tracks.size()},
                             {"observations", attempt.adjusted.observations},
                             {"dropped", attempt.adjusted.dropped},
                             {"residual_px", attempt.adjusted.rms_px},
                             {"iterations", attempt.adjusted.iterations}});
  attempt.iterations += attempt.adjusted.iterations;
  attempt.is_adjusted = true;
  return attempt;
}

Relief AdjustedRelief(const Attempt& attempt) {
  const double cell_m = kReliefCellGsds * MedianWidthM(attempt.input.views) / kResidualWidthPx;
  return Relief::FromPoints(ReliefPoints(attempt.problem.tracks), cell_m, attempt.posed.ground_z_in_enu_m);
}

Attempt Rematched(Attempt attempt, const MatchingPass& pass, const AlignOptions& options) {
  const std::size_t count = attempt.input.views.size();
  {
    ScopedTimer timer(attempt.matching_s);
    attempt.input.views = ViewsOf(attempt.problem);
    attempt.relief = AdjustedRelief(attempt);
    attempt.matched.pairs = OnlyWithinComponents(
        SelectPairs(attempt.input.views, std::vector<double>(count, 0.0), attempt.relief, {}),
        attempt.matched.links, count);
    attempt.matched.links = {};  // not both at a time
    attempt.matched.links =
        MatchAndVerify(attempt.input, ProjectAllToGround(attempt.input, attempt.relief, options.threads),
                       attempt.matched.pairs, pass, options.threads);
  }
  TraceDecision("compared again",
                {{"pairs", attempt.matched.pairs.size()}, {"verified", attempt.matched.links.size()}});
  return attempt;
}

std::vector<Track> GroundTracks(const Attempt& attempt, const AlignOptions& options) {
  const std::vector<View>& views = attempt.input.views;
  TrackOptions track_options;
  track_options.observations_per_photo = options.max_features;
  track_options.splits_contradictory = true;
  std::vector<Track> tracks =
      BuildTracks(attempt.matched.links, attempt.input.features, views, track_options);
  std::erase_if(tracks, [&](Track& track) {
    // The observation with the largest error goes first, for it pulls the point away from the others.
    while (track.observations.size() >= 2 && Triangulate(views, track)) {
      const auto error = [&](const Observation& one) {
        return ReprojectionErrorPx(views[one.photo], one, track.point_in_enu) / one.sigma_px;
      };
      const auto worst =
          std::max_element(track.observations.begin(), track.observations.end(),
                           [&](const Observation& a, const Observation& b) { return error(a) < error(b); });
      if (error(*worst) <= kGroundSigmas) return false;
      track.observations.erase(worst);
    }
    return true;
  });
  return tracks;
}

}  // namespace skyquilt::alignment
