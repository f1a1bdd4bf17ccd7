#include "core/alignment/baselines/align_directly.h"

#include <algorithm>
#include <cmath>

#include "core/alignment/baselines/align_by_pose.h"
#include "core/alignment/features/features.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/direct_registration.h"
#include "core/base/scoped_timer.h"

namespace skyquilt::alignment {

Result<AlignedFlight> AlignDirectly(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                    const AlignOptions& options, AlignReport& report, Progress& progress) {
  constexpr int kPasses = 2;
  report = {};
  ScopedTimer total_timer(report.total_s);
  const FeatureOptions thumbnails_only{.detector_pixels = options.features.detector_pixels,
                                       .max_features = 0};
  const Photographed photographed =
      ExtractAll(posed, source, thumbnails_only, {}, options.threads, 0.8, progress);
  const std::size_t count = posed.photos.size();
  MatchingInput input = MakeMatchingInput(posed);
  input.features = photographed.Readable();
  std::vector<CorrectedPose> as_recorded;
  for (const poses::PosedPhoto& photo : posed.photos) {
    CorrectedPose& uncorrected = as_recorded.emplace_back();
    uncorrected.start_cam_from_enu = uncorrected.prior_cam_from_enu = photo.cam_from_enu;
  }
  const Relief flat(posed.ground_z_in_enu_m);
  BundleProblem problem = MakeBundle(posed, as_recorded, FindLines(EastNorthOf(posed.photos)));
  // One shift a pair says nothing of the lens.
  const BundleOptions once{.cuts_px = {0.0}, .adjust_lens = false};
  for (int pass = 0; pass < kPasses && !progress.IsCancelled(); ++pass) {
    progress.Report(0.8 + 0.1 * pass, "comparing photos");
    const std::vector<CandidatePair> pairs = SelectPairs(input.views, input.ground_sigma_m, flat);
    report.pairs_tried = static_cast<int>(pairs.size());
    {
      ScopedTimer timer(report.matching_s);
      problem.soft_tracks = DirectTracks(input, pairs, {}, flat, options.threads);
    }
    ScopedTimer timer(report.adjustment_s);
    const BundleSummary summary = AdjustBundle(problem, once);
    report.iterations += summary.iterations;
    report.solver = summary.solver;
    input.views = ViewsOf(problem);
  }
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The alignment was cancelled.", ""};

  const std::vector<DirectSupport> support = SupportOf(input.views, problem.soft_tracks);
  AlignedFlight flight = AlignByPoseOnly(posed);
  double square_px = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    AlignedPhoto& photo = flight.photos[i];
    AlignPhotoReport told;
    told.name = photo.photo.name;
    report.decode_s += photographed.features[i].decode_s;
    if (support[i].ties > 0) {
      photo.cam_from_enu = problem.photos[i].cam_from_enu;
      photo.placement = Placement::kAligned;
      photo.placement_remarks = {{flight::RemarkCode::kMovedToFit, {{"photos", support[i].ties}}}};
      photo.height_above_ground_m =
          std::max(0.5, photo.cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m);
      ++report.aligned;
      told.residual_rms_px = std::sqrt(support[i].square_px / support[i].ties);
      square_px += support[i].square_px;
    } else {
      const std::string& unreadable = photographed.unreadable[i];
      photo.placement_remarks = {unreadable.empty() ? flight::Remark(flight::RemarkCode::kByPoseNoFit)
                                                    : flight::Remark{flight::RemarkCode::kByPoseUnreadable,
                                                                     {{"error_words", unreadable}}}};
    }
    told.placement = photo.placement;
    told.remarks = photo.placement_remarks;
    told.links = told.observations = support[i].ties;
    report.observations += support[i].ties;
    report.photo_reports.push_back(std::move(told));
  }
  report.photos = static_cast<int>(count);
  report.pairs_linked = report.pairs_by_direct = static_cast<int>(problem.soft_tracks.size());
  report.tie_points = report.pairs_by_direct;
  report.residual_rms_px = report.observations > 0 ? std::sqrt(square_px / report.observations) : 0.0;
  progress.Report(1.0, "aligned");
  return flight;
}

}  // namespace skyquilt::alignment
