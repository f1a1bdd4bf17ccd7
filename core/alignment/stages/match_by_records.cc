#include "core/alignment/stages/match_by_records.h"

#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

// Photos that are placed already are no matter of doubt, whatever the verified pairs suggested.
void HoldFixed(const poses::PosedFlight& posed, const PhotoSet& fixed, BundleProblem& problem) {
  for (std::size_t i = 0; i < fixed.Photos(); ++i) {
    if (!fixed.Has(i)) continue;
    BundlePhoto& photo = problem.photos[i];
    photo.cam_from_enu = photo.prior_cam_from_enu = posed.photos[i].cam_from_enu;
    photo.is_fixed = true;
    problem.lenses[photo.lens].is_fixed = true;
  }
}

}  // namespace

Result<Attempt> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                               Progress& progress) {
  const std::size_t count = extracted.posed.photos.size();
  Attempt attempt;
  attempt.posed = extracted.posed;
  attempt.relief = Relief(attempt.posed.ground_z_in_enu_m);
  attempt.input = MakeMatchingInput(attempt.posed);
  attempt.input.features = extracted.readable;
  for (std::size_t i = 0; i < count; ++i) {
    if (extracted.records[i].is_unplaced) attempt.input.features[i] = nullptr;  // until the images place it
    const poses::PosedPhoto& photo = attempt.posed.photos[i];
    if (photo.photo.turning) attempt.input.views[i].readout_motion = ReadoutMotion(photo, 0);
  }
  {
    ScopedTimer timer(attempt.matching_s);
    progress.Report(0.7, "comparing photos");
    attempt.matched = MatchInPasses(attempt.posed, extracted.lines, attempt.input, options.threads, progress);
  }
  if (progress.IsCancelled()) return AlignmentCancelled();
  TraceDecision("compared by records", {{"pairs", attempt.matched.pairs.size()},
                                        {"verified", attempt.matched.links.size()},
                                        {"refused", attempt.matched.rejected.size()}});
  attempt.compared = attempt.matched.pairs;
  attempt.problem = MakeBundle(attempt.posed, attempt.matched.corrected, extracted.lines);
  if (options.fixed.Photos() > 0) {
    HoldFixed(attempt.posed, options.fixed, attempt.problem);
    attempt.input.views = ViewsOf(attempt.problem);
  }
  return attempt;
}

}  // namespace skyquilt::alignment
