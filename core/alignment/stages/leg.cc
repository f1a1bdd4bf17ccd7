#include "core/alignment/stages/leg.h"

#include <algorithm>
#include <utility>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/scene/tracks.h"
#include "core/base/large_blocks_apart.h"
#include "core/base/median.h"
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

WeighedLeg AsWeighed(const ExtractedFlight& extracted, const Leg& leg) {
  return {&extracted.records,
          &extracted.readable,
          &leg.matched.links,
          &leg.problem,
          ResidualAtWidth(leg.adjusted.rms_px, leg.posed),
          leg.adjusted.observations,
          leg.adjusted.dropped,
          leg.is_adjusted};
}

Leg Adjusted(Leg leg, const BundleOptions& bundle_options, const AlignOptions& options) {
  if (leg.input.views.size() >= kManyPhotos) ReturnFreedMemory();  // the matcher's, before the solver's
  TrackOptions track_options;
  track_options.observations_per_photo = options.observations_per_photo;
  {
    ScopedTimer timer(leg.adjustment_s);
    leg.problem.tracks = {};  // not both at a time
    leg.problem.tracks = BuildTracks(leg.matched.links, leg.input.features, leg.input.views, track_options);
    std::erase_if(leg.problem.tracks, [&](Track& track) { return !Triangulate(leg.input.views, track); });
    leg.adjusted = AdjustBundle(leg.problem, bundle_options);
  }
  TraceDecision("adjusted", {{"points", leg.problem.tracks.size()},
                             {"observations", leg.adjusted.observations},
                             {"dropped", leg.adjusted.dropped},
                             {"residual_px", leg.adjusted.rms_px},
                             {"iterations", leg.adjusted.iterations}});
  leg.iterations += leg.adjusted.iterations;
  leg.is_adjusted = true;
  return leg;
}

Relief AdjustedRelief(const Leg& leg) {
  const double cell_m = kReliefCellGsds * MedianWidthM(leg.input.views) / kResidualWidthPx;
  return Relief::FromPoints(ReliefPoints(leg.problem.tracks), cell_m, leg.posed.ground_z_in_enu_m);
}

Leg Rematched(Leg leg, const MatchingPass& pass, const AlignOptions& options) {
  const std::size_t count = leg.input.views.size();
  {
    ScopedTimer timer(leg.matching_s);
    leg.input.views = ViewsOf(leg.problem);
    leg.relief = AdjustedRelief(leg);
    leg.matched.pairs =
        OnlyWithinComponents(SelectPairs(leg.input.views, std::vector<double>(count, 0.0), leg.relief, {}),
                             leg.matched.links, count);
    leg.matched.links = {};  // not both at a time
    leg.matched.links = MatchAndVerify(leg.input, ProjectAllToGround(leg.input, leg.relief, options.threads),
                                       leg.matched.pairs, pass, options.threads);
  }
  TraceDecision("compared again",
                {{"pairs", leg.matched.pairs.size()}, {"verified", leg.matched.links.size()}});
  return leg;
}

std::vector<Track> GroundTracks(const Leg& leg, const AlignOptions& options) {
  const std::vector<View>& views = leg.input.views;
  TrackOptions track_options;
  track_options.observations_per_photo = options.max_features;
  track_options.splits_contradictory = true;
  std::vector<Track> tracks = BuildTracks(leg.matched.links, leg.input.features, views, track_options);
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
