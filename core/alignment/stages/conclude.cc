#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/bundle/control_points.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/alignment/stages/attempt_steps.h"
#include "core/alignment/stages/doubt_photos.h"
#include "core/alignment/stages/track_ties.h"
#include "core/base/median.h"
#include "core/base/trace.h"
#include "core/base/try.h"

namespace skyquilt::alignment {
namespace {

using flight::Remark;

void ReportLenses(const poses::PosedFlight& posed, const BundleProblem& problem, AlignReport& report) {
  for (std::size_t c = 0; c < problem.lenses.size(); ++c) {
    const BundleLens& lens = problem.lenses[c];
    AlignLensReport told;
    for (std::size_t i = 0; i < problem.photos.size(); ++i) {
      if (problem.photos[i].lens == static_cast<int>(c)) {
        told.camera_key = posed.photos[i].photo.camera_key;
        told.recorded = posed.photos[i].photo.intrinsics;
        break;
      }
    }
    told.adjusted = lens.intrinsics;
    told.sigma_focal_px = lens.found_sigma_focal_px;
    const double prior_sigma_px = lens.sigma_focal_share * lens.recorded.focal_x_px;
    told.focal_is_held = lens.found_sigma_focal_px <= 0.0 || lens.found_sigma_focal_px > 0.5 * prior_sigma_px;
    report.lenses.push_back(told);
  }
}

// Surveyed points further from where the photos agree they are than any survey errs; nothing: they fit.
std::optional<Remark> ContradictedControl(const std::vector<ControlReport>& control) {
  std::vector<double> errors_m;
  for (const ControlReport& point : control) {
    if (point.is_used) errors_m.push_back(std::hypot(point.miss_east_m, point.miss_north_m));
  }
  if (errors_m.size() < kMinContradicted) return std::nullopt;
  const double median_m = Median(errors_m);
  if (median_m < kNoSurveyM) return std::nullopt;
  return Remark{flight::RemarkCode::kControlContradicts,
                {{"points", errors_m.size()}, {"apart_m", median_m}}};
}

// Nothing where no clock was found wrong by what can be seen on a map.
std::optional<flight::Remark> RemarkOfClock(const BundleProblem& problem) {
  constexpr double kSeenS = 0.1, kSeenM = 0.1;
  std::vector<double> speeds_mps;
  for (const BundlePhoto& photo : problem.photos) {
    if (!photo.by_clock_mps.isZero()) speeds_mps.push_back(photo.by_clock_mps.norm());
  }
  const double clock_s = std::abs(problem.clock_error_s);
  if (speeds_mps.empty() || clock_s < kSeenS) return std::nullopt;
  const double moved_m = clock_s * Median(std::move(speeds_mps));
  if (moved_m < kSeenM) return std::nullopt;
  return flight::Remark{
      problem.clock_error_s > 0.0 ? flight::RemarkCode::kClockBehind : flight::RemarkCode::kClockAhead,
      {{"clock_s", clock_s}, {"moved_m", moved_m}}};
}

// Seen by a photo that is not of a map that stays.
int TiePointsOfNew(const BundleProblem& problem) {
  return static_cast<int>(
      std::count_if(problem.tracks.begin(), problem.tracks.end(), [&](const Track& track) {
        return std::any_of(track.observations.begin(), track.observations.end(),
                           [&](const Observation& one) { return !problem.photos[one.photo].is_fixed; });
      }));
}

void ReportAttempt(const ExtractedFlight& extracted, const Attempt& attempt, AlignReport& report) {
  const std::vector<std::string> names = extracted.posed.Names();
  report.photos = static_cast<int>(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const PhotoFeatures& features = extracted.features[i];
    AlignPhotoReport& told = report.photo_reports.emplace_back();
    told.name = names[i];
    told.features = static_cast<int>(features.keypoints.size());
    told.is_by_images = attempt.problem.photos[i].is_by_images;
    report.decode_s += features.decode_s;
    report.features_s += features.detect_s;
  }
  report.gyros = extracted.gyros;
  report.pairs_tried = static_cast<int>(attempt.matched.pairs.size());
  report.pairs_linked = static_cast<int>(attempt.matched.links.size());
  report.pairs_rejected = static_cast<int>(report.rejected_pairs.size());
  for (Remark& remark : DescribeCorrections(attempt.matched.findings, names, extracted.lines))
    report.corrections.push_back(std::move(remark));
  if (auto remark = RemarkOfClock(attempt.problem))
    report.corrections.insert(report.corrections.begin(), *std::move(remark));
  report.pairs = PairsInUse(attempt.problem, names);
  ReportControl(attempt.problem, report.control);
  PredictControl(attempt.problem, report.control);
  report.position_bias_m = attempt.problem.position_bias_m;
  report.tie_points = static_cast<int>(attempt.problem.tracks.size());
  report.tie_points_of_new = TiePointsOfNew(attempt.problem);
  report.observations = attempt.adjusted.observations;
  report.observations_dropped = attempt.adjusted.dropped;
  report.residual_rms_px = attempt.adjusted.rms_px;
  report.solver = attempt.adjusted.solver;
  ReportLenses(attempt.posed, attempt.problem, report);
}

// What the user must know, the most important first, and what was corrected last.
void Warn(const AlignReport& report, const AttemptEvidence& evidence, AlignedFlight& flight) {
  std::vector<Remark> remarks;
  const auto add = [&](std::optional<Remark> remark) {
    if (remark) remarks.push_back(*std::move(remark));
  };
  const auto add_all = [&](const std::vector<Remark>& more) {
    remarks.insert(remarks.end(), more.begin(), more.end());
  };
  add(ContradictedControl(report.control));
  add(DroppedOf(report.observations, report.observations_dropped));
  if (!report.by_images.is_taken) add(ContradictionOf(evidence));
  add_all(RemarksOn(report.by_images));
  add_all(flight.warnings);
  add_all(RemarksOn(report.control));
  add_all(report.corrections);
  flight.warnings = std::move(remarks);
}

}  // namespace

Result<AlignedFlight> Conclude(const ExtractedFlight& extracted, Attempt attempt, AlignReport& report) {
  ForgiveTurnsAtBends(extracted.posed.photos, attempt.matched.findings);
  const AttemptEvidence evidence = Weigh(extracted, attempt);
  report = std::move(attempt.report);
  if (!report.by_images.why) {
    report.by_images.outcome = flight::Remark{flight::RemarkCode::kRecordsHold,
                                              {{"photos", evidence.tied}, {"total", evidence.readable}}};
  }
  DoubtPhotos(attempt.compared, attempt.relief, attempt.matched);
  ReportAttempt(extracted, attempt, report);
  attempt.matched.views = ViewsOf(attempt.problem);
  const std::vector<Track> ground_tracks = GroundTracks(attempt);
  AlignedFlight flight = PlacePhotos(extracted, attempt, ground_tracks, report);
  SKYQUILT_TRY(SettleUnplaced(extracted, flight, report));
  for (const AlignPhotoReport& photo : report.photo_reports) {
    const bool is_far =
        std::find(photo.faults.begin(), photo.faults.end(), PhotoFault::kFarAway) != photo.faults.end();
    TraceDecision(is_far                                   ? "photo far away"
                  : photo.placement == Placement::kAligned ? "photo aligned"
                                                           : "photo by its pose alone",
                  {{"tied_to", photo.links},
                   {"observations", photo.observations},
                   {"residual_px", photo.residual_rms_px},
                   {"moved_m", photo.moved_m},
                   {"turned_deg", photo.turned_deg}},
                  photo.name);
  }
  Warn(report, evidence, flight);
  return flight;
}

}  // namespace skyquilt::alignment
