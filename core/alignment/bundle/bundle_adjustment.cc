#include "core/alignment/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr double kOutlierSigmas = 3.5;

// By how much the observations of each photo spread, against the sigmas they were given. Where the others
// agree better than was assumed of keypoints, an error assumed usual is an outlier. Bounded below: less sharp
// photos have larger errors and are needed all the same. A camera that turned while it read its rows is known
// better in one photo than in another, so that each of those has its own.
std::vector<double> SpreadsOf(const std::vector<View>& views, const std::vector<Track>& tracks) {
  constexpr double kMinSpread = 0.7, kMinOwnSpread = 0.25;
  std::vector<double> all;
  std::vector<std::vector<double>> of_photo(views.size());
  for (const Track& track : tracks) {
    for (const Observation& seen : track.observations) {
      all.push_back(ReprojectionErrorPx(views[seen.photo], seen, track.point_in_enu) / seen.sigma_px);
      if (!views[seen.photo].readout_motion.turns_rad.empty()) of_photo[seen.photo].push_back(all.back());
    }
  }
  const double common =
      all.empty() ? 1.0 : std::clamp(Median(std::move(all)) / kMedianInPlane, kMinSpread, 1.0);
  std::vector<double> spreads(views.size(), common);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (of_photo[i].empty()) continue;
    spreads[i] = std::clamp(Median(std::move(of_photo[i])) / kMedianInPlane, kMinOwnSpread, common);
  }
  return spreads;
}

// Drops what lies too far off, and points that then hang on one ray; returns the number dropped.
int DropOutliers(const std::vector<View>& views, double cut_px, std::vector<Track>& tracks) {
  int dropped = 0;
  const std::vector<double> spreads = SpreadsOf(views, tracks);
  for (Track& track : tracks) {
    auto& seen = track.observations;
    const std::size_t before = seen.size();
    std::erase_if(seen, [&](const Observation& one) {
      const double scale = views[one.photo].intrinsics.width_px / kReferenceWidthPx;
      const double cut = cut_px > 0.0 ? std::max(cut_px * scale, kOutlierSigmas * one.sigma_px)
                                      : kOutlierSigmas * spreads[one.photo] * one.sigma_px;
      return ReprojectionErrorPx(views[one.photo], one, track.point_in_enu) > cut;
    });
    dropped += static_cast<int>(before - seen.size());
  }
  // Two photos from one place (a copy, a hover) do not hold a point.
  std::erase_if(tracks, [&](const Track& track) {
    return track.observations.size() < 2 || WidestAngle(views, track) < kMinAngleRad;
  });
  return dropped;
}

// Ties of whole pictures, of which one photo was since found to look elsewhere: with a point behind a camera
// no round succeeds.
void DropTiesBehind(const std::vector<View>& views, std::vector<Track>& ties) {
  std::erase_if(ties, [&](const Track& tie) {
    return std::any_of(tie.observations.begin(), tie.observations.end(), [&](const Observation& one) {
      return std::isinf(ReprojectionErrorPx(views[one.photo], one, tie.point_in_enu));
    });
  });
}

}  // namespace

Eigen::Vector3d ExpectedCenter(const BundleProblem& problem, const BundlePhoto& photo) {
  return photo.prior_cam_from_enu.TargetOriginInSource() + problem.position_bias_m +
         problem.clock_error_s * photo.by_clock_mps;
}

std::vector<View> ViewsOf(const BundleProblem& problem) {
  std::vector<View> views;
  views.reserve(problem.photos.size());
  for (const BundlePhoto& photo : problem.photos) {
    views.push_back({problem.lenses[photo.lens].intrinsics, photo.cam_from_enu, photo.height_above_ground_m,
                     photo.readout_motion});
  }
  return views;
}

BundleSummary AdjustBundle(BundleProblem& problem, const BundleOptions& options) {
  BundleSummary summary;
  DropTiesBehind(ViewsOf(problem), problem.soft_tracks);
  std::vector<Eigen::Vector3d> line_bias_rad(problem.lines, Eigen::Vector3d::Zero());
  BundleOptions round_options = options;
  for (std::size_t round = 0; round < options.cuts_px.size(); ++round) {
    round_options.estimate_lens_sigma = options.estimate_lens_sigma && round + 1 == options.cuts_px.size();
    SolveRound(round_options, problem, line_bias_rad, summary);
    summary.dropped += DropOutliers(ViewsOf(problem), options.cuts_px[round], problem.tracks);
  }
  const std::vector<View> views = ViewsOf(problem);
  double square = 0.0;
  for (Track& track : problem.tracks) {
    track.angle_rad = WidestAngle(views, track);
    for (const Observation& seen : track.observations) {
      const double residual = ReprojectionErrorPx(views[seen.photo], seen, track.point_in_enu);
      square += residual * residual;
      ++summary.observations;
    }
  }
  summary.rms_px = summary.observations > 0 ? std::sqrt(square / summary.observations) : 0.0;
  return summary;
}

}  // namespace skyquilt::alignment
