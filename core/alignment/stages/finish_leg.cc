#include "core/alignment/stages/finish_leg.h"

#include <utility>

#include "core/alignment/adjustment/bundle_setup.h"
#include "core/alignment/adjustment/tie_to_control.h"

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

}  // namespace

Leg FinishLeg(Leg leg, const AlignOptions& options, Progress& progress) {
  progress.Report(0.88, "comparing photos once more");
  leg = Rematched(std::move(leg), kLastPass, options);
  progress.Report(0.92, "adjusting");
  ReweighPriors(leg.problem);
  leg.problem.plane = FitPlane(leg.problem);
  BundleOptions last;
  last.estimate_lens_sigma = leg.problem.photos.size() <= kMaxPhotosForLensSigma;
  leg = Adjusted(std::move(leg), last, options);
  if (BelieveContradictedControlLess(leg.problem)) leg = Adjusted(std::move(leg), last, options);
  return leg;
}

}  // namespace skyquilt::alignment
