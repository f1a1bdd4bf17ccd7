#include "core/alignment/stages/match_by_records.h"

#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

// Photos that are placed already are no matter of doubt, whatever the verified pairs suggested.
void HoldFixed(const poses::PosedFlight& posed, const std::vector<char>& fixed, BundleProblem& problem) {
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i] == 0) continue;
    BundlePhoto& photo = problem.photos[i];
    photo.cam_from_enu = photo.prior_cam_from_enu = posed.photos[i].cam_from_enu;
    photo.is_fixed = true;
    problem.lenses[photo.lens].is_fixed = true;
  }
}

}  // namespace

Result<Leg> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                           Progress& progress) {
  const std::size_t count = extracted.posed.photos.size();
  Leg leg;
  leg.posed = extracted.posed;
  leg.relief = Relief(leg.posed.ground_z_in_enu_m);
  leg.input = MakeMatchingInput(leg.posed);
  leg.input.features = extracted.readable;
  for (std::size_t i = 0; i < count; ++i) {
    if (extracted.records[i].is_unplaced) leg.input.features[i] = nullptr;  // until the images place it
    const poses::PosedPhoto& photo = leg.posed.photos[i];
    if (photo.photo.turning) leg.input.views[i].readout_motion = ReadoutMotion(photo, 0);
  }
  {
    ScopedTimer timer(leg.matching_s);
    progress.Report(0.7, "comparing photos");
    leg.matched = MatchInPasses(leg.posed, extracted.lines, leg.input, options.threads, progress);
  }
  if (progress.IsCancelled()) return AlignmentCancelled();
  TraceDecision("compared by records", {{"pairs", leg.matched.pairs.size()},
                                        {"verified", leg.matched.links.size()},
                                        {"refused", leg.matched.rejected.size()}});
  leg.compared = leg.matched.pairs;
  leg.problem = MakeBundle(leg.posed, leg.matched.corrected, extracted.lines);
  if (!options.fixed.empty()) {
    HoldFixed(leg.posed, options.fixed, leg.problem);
    leg.input.views = ViewsOf(leg.problem);
  }
  return leg;
}

}  // namespace skyquilt::alignment
