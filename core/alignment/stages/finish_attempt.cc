#include "core/alignment/stages/finish_attempt.h"

#include <fmt/format.h>

#include <utility>

#include "core/alignment/bundle/find_readout.h"
#include "core/alignment/bundle/tie_to_control.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

// From the adjusted poses, on the adjusted relief.
const MatchingPass kLastPass{.min_radius_share = 0.012,
                             .sigmas = 0.0,
                             .max_turn_rad = 0.35,
                             .max_distance_ratio = 0.9,
                             .min_matches = 8,
                             .fit_motion = false};

constexpr std::size_t kMaxPhotosForLensSigma = 200;  // its cost grows with their square

// Photos of which nobody recorded how their rows were read, and which lie as they were.
PhotoSet MayRoll(const poses::PosedFlight& posed) {
  PhotoSet may_roll;
  for (const poses::PosedPhoto& one : posed.photos) {
    const flight::Photo& photo = one.photo;
    may_roll.Append(!photo.readout_s && !one.readout_motion && !photo.is_resaved_by_viewer &&
                    photo.intrinsics.width_px >= photo.intrinsics.height_px);
  }
  return may_roll;
}

// The attempt adjusted with a readout time for lenses whose photos show one, if they do.
Attempt WithReadoutFound(Attempt attempt, const BundleOptions& bundle_options, const AlignOptions& options) {
  const PhotoSet may_roll = MayRoll(attempt.posed);
  const std::vector<int> lenses = LensesThatMayRoll(attempt.problem, may_roll);
  if (lenses.empty()) return attempt;
  Attempt found = attempt;
  for (std::size_t i = 0; i < may_roll.Photos(); ++i) {
    if (!may_roll.Has(i)) found.problem.photos[i].velocity_in_enu_mps.reset();
  }
  for (const int lens : lenses) found.problem.lenses[lens].finds_readout = true;
  found = Adjusted(std::move(found), bundle_options, options);
  const std::vector<int> rolling = LensesThatRoll(found.problem, lenses);
  TraceDecision("rolling shutter looked for", {{"lenses", lenses.size()}, {"found", rolling.size()}});
  if (rolling.size() < lenses.size()) {
    attempt.iterations = found.iterations;
    return attempt;
  }
  // What was matched by photos taken for still ones is matched anew.
  found = Adjusted(Rematched(std::move(found), kLastPass, options), bundle_options, options);
  for (const int lens : rolling) {
    int photos = 0;
    std::string camera;
    for (std::size_t i = 0; i < found.problem.photos.size(); ++i) {
      if (found.problem.photos[i].lens != lens || !may_roll.Has(i)) continue;
      ++photos;
      camera = found.posed.photos[i].photo.model;
    }
    found.corrected_records.push_back({flight::RemarkCode::kRollingShutterFound,
                                       {{"camera", camera.empty() ? "The camera" : camera},
                                        {"readout_ms", 1e3 * std::abs(found.problem.lenses[lens].readout_s)},
                                        {"photos", photos}}});
  }
  return found;
}

}  // namespace

Attempt FinishAttempt(Attempt attempt, const AlignOptions& options, Progress& progress) {
  progress.Report(0.88, "comparing photos once more");
  attempt = Rematched(std::move(attempt), kLastPass, options);
  progress.Report(0.92, "adjusting");
  ReweighPriors(attempt.problem);
  attempt.problem.plane = FitPlane(attempt.problem);
  BundleOptions last;
  last.estimate_lens_sigma = attempt.problem.photos.size() <= kMaxPhotosForLensSigma;
  attempt = Adjusted(std::move(attempt), last, options);
  attempt = WithReadoutFound(std::move(attempt), last, options);
  if (BelieveContradictedControlLess(attempt.problem)) attempt = Adjusted(std::move(attempt), last, options);
  return attempt;
}

}  // namespace skyquilt::alignment
