#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/attempts/lost_photos.h"
#include "core/alignment/bundle/control_points.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/direct_registration.h"
#include "core/alignment/from_records/level_flight.h"
#include "core/alignment/from_records/position_lag.h"
#include "core/alignment/stages/attempt_steps.h"
#include "core/base/median.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

// From poses adjusted a first time, where they came from records that were degrees off: a motion over level
// ground fits only part of what two such photos share, so the rest is still to be found.
const MatchingPass kMiddlePass{.min_radius_share = 0.05,
                               .sigmas = 0.0,
                               .max_turn_rad = 0.45,
                               .tolerance_share = 0.015,
                               .min_matches = 8};
constexpr double kMuchLeanedShare = 0.02;  // of a photo's width that a turn of the axis moves its middle by

// Of the readable photos, those that may stay lost before the records are doubted as a whole: by links alone,
// when nothing has been adjusted and hardly anything would be worth it, and after everything was tried.
constexpr double kMaxLostShareByLinks = 0.4;
constexpr double kMaxLostShare = 0.1;
constexpr int kMaxLostRounds = 5;

constexpr double kNearlyAll = 0.9;
constexpr double kSoundResidualShare = 0.001;  // of a photo's width

BundleOptions FirstAdjustment() { return {.cuts_px = {30.0, 10.0}, .max_iterations = 15}; }

// Of photos that have been adjusted to each other.
BundleOptions SettledAdjustment() { return {.cuts_px = {10.0}, .max_iterations = 8}; }

// How far the adjustment swung the photos' axes over the ground, in photo widths: half of them further.
double LeanedShare(const std::vector<PhotoFindings>& corrected, const BundleProblem& problem) {
  const std::vector<View> views = ViewsOf(problem);
  std::vector<double> shares{0.0};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Quaterniond before = corrected[i].start_cam_from_enu.rotation.conjugate();
    const Eigen::Quaterniond now = views[i].cam_from_enu.rotation.conjugate();
    const double swung = ((now * Eigen::Vector3d::UnitZ()) - (before * Eigen::Vector3d::UnitZ())).norm();
    if (swung > 0.0) shares.push_back(swung * views[i].height_above_ground_m / views[i].WidthM());
  }
  return Median(std::move(shares));
}

// The attempt by images, not adjusted; none where the records hold, or where it ties no more photos together.
// by_records.report says which.
std::optional<Attempt> TryByImages(const ExtractedFlight& extracted, double max_lost_share,
                                   const AlignOptions& options, Attempt& by_records, Progress& progress) {
  const AttemptEvidence evidence = Weigh(extracted, by_records);
  const bool is_asked_for = options.by_images == ByImages::kAlways;
  std::optional<flight::Remark>& why = by_records.report.by_images.why;
  why = is_asked_for ? flight::Remark(flight::RemarkCode::kImagesAskedFor)
                     : WhyDoubted(evidence, max_lost_share);
  TraceDecision(why ? "records doubted" : "records held",
                {{"photos", evidence.readable},
                 {"tied", evidence.tied},
                 {"unplaced", evidence.unplaced},
                 {"residual_px", evidence.residual_rms_px},
                 {"dropped_share", evidence.DroppedShare()},
                 {"contradicted", evidence.positions_contradicted}});
  if (!why) return std::nullopt;
  progress.Report(0.82, "placing photos by what they show");
  // Where residuals are in doubt, as many photos tied are not better by number.
  const bool takes_equal = is_asked_for || evidence.Lost() == 0;
  return PlaceByImages(extracted, evidence.tied, takes_equal, options.control, options.threads, by_records,
                       progress);
}

// So many of the photos that show anything, and so well, that the records need no adjustment to be compared.
bool IsNearlyAll(const ExtractedFlight& extracted, const ByImagesReport& by_images) {
  const auto readable = std::count_if(extracted.readable.begin(), extracted.readable.end(), ShowsEnough);
  return by_images.registered >= kNearlyAll * static_cast<double>(readable) &&
         by_images.residual_rms_px < kSoundResidualShare * MedianWidthPx(extracted.posed);
}

Attempt TiedDirectly(Attempt attempt, const AlignOptions& options) {
  {
    ScopedTimer timer(attempt.report.matching_s);
    attempt.problem.soft_tracks = DirectTracks(attempt.matched, attempt.relief, options.threads);
  }
  attempt.report.pairs_by_direct = static_cast<int>(attempt.problem.soft_tracks.size());
  return attempt;
}

// Pairs verified by the geometry of two views are not given up for those that one motion over the ground
// explains.
enum class MayRematch { kNo, kYes };

// Photos that the adjusted attempt leaves apart, registered against the others.
Attempt WithLostTakenIn(const ExtractedFlight& extracted, Attempt attempt, MayRematch may_rematch,
                        const AlignOptions& options) {
  bool took_in = false, is_rematched = false;
  for (int round = 0; round < kMaxLostRounds && HasLost(Weigh(extracted, attempt)); ++round) {
    attempt.matched.views = ViewsOf(attempt.problem);
    const std::vector<Track> seen = GroundTracks(attempt);
    if (TakeInLost(extracted, seen, options.threads, attempt) == 0) {
      // Photos just taken in have few points yet, and may be all that the next ones have in common with the
      // rest.
      if (!took_in || is_rematched || may_rematch == MayRematch::kNo) break;
      attempt = Rematched(std::move(attempt), kMiddlePass, options);
      is_rematched = true;
    } else {
      took_in = true;
    }
    attempt = Adjusted(std::move(attempt), FirstAdjustment());
  }
  return attempt;
}

// Adjusted from the records, and photos that these left apart registered against the others.
Attempt AdjustedByRecords(const ExtractedFlight& extracted, Attempt attempt, const AlignOptions& options) {
  attempt = Adjusted(std::move(attempt), FirstAdjustment());
  attempt.matched.views = ViewsOf(attempt.problem);
  attempt.relief = AdjustedRelief(attempt);
  attempt.problem.plane = FitPlane(attempt.problem);
  return WithLostTakenIn(extracted, std::move(attempt), MayRematch::kYes, options);
}

// The attempt by images, adjusted, with what was counted before; where both are compared, the better of both.
Attempt BetterOf(const ExtractedFlight& extracted, Attempt by_records, Attempt by_images, bool compares,
                 const AlignOptions& options) {
  by_images.report = std::move(by_records.report);
  ByImagesReport& report = by_images.report.by_images;
  report.is_taken = true;
  const bool may_keep_records = compares && options.by_images != ByImages::kAlways;
  if (!may_keep_records) by_records = Attempt();  // not both at a time
  by_images = Adjusted(std::move(by_images), SettledAdjustment());
  by_images.matched.views = ViewsOf(by_images.problem);
  by_images.relief = AdjustedRelief(by_images);
  by_images = WithLostTakenIn(extracted, std::move(by_images), MayRematch::kNo, options);
  const AttemptEvidence evidence = Weigh(extracted, by_images);
  if (static_cast<int>(evidence.tied) > report.registered) {
    report.registered = static_cast<int>(evidence.tied);
    report.outcome->values.insert_or_assign("photos", report.registered);
  }
  if (may_keep_records) {
    const AttemptEvidence of_records = Weigh(extracted, by_records);
    std::optional<flight::Remark> why_not = WhyImagesLose(of_records, evidence);
    TraceDecision(why_not ? "records taken" : "images taken",
                  {{"tied_by_images", evidence.tied},
                   {"tied_by_records", of_records.tied},
                   {"residual_by_images_px", evidence.residual_rms_px},
                   {"residual_by_records_px", of_records.residual_rms_px}});
    if (why_not) {
      report.is_taken = report.is_placed = false;
      report.outcome = NotTaken(*std::move(why_not));
      by_records.report = std::move(by_images.report);
      return by_records;
    }
  }
  return by_images;
}

// Adjusted anew where wrong heights held the flight tilted.
Attempt Levelled(const ExtractedFlight& extracted, Attempt attempt) {
  const std::optional<Levelling> levelling = FindLevelling(attempt.problem, extracted.records);
  if (!levelling) return attempt;
  TraceDecision("flight levelled",
                {{"tilt_rad", levelling->tilt_rad}, {"apart_m", levelling->height_range_m}});
  Level(*levelling, extracted.records, attempt.problem);
  attempt.matched.views = ViewsOf(attempt.problem);
  attempt = Adjusted(std::move(attempt), SettledAdjustment());
  attempt.report.corrections.push_back({flight::RemarkCode::kHeightsTilted,
                                        {{"tilt_deg", levelling->tilt_rad * 180.0 / std::numbers::pi},
                                         {"apart_m", levelling->height_range_m}}});
  return attempt;
}

// Seconds since the first photo; without times of all, or with times that do not rise, photos since the
// first.
struct CaptureTimes {
  std::vector<double> times_s;
  bool are_seconds = true;
};

CaptureTimes TimesOf(const poses::PosedFlight& posed) {
  CaptureTimes times;
  for (const poses::PosedPhoto& photo : posed.photos) {
    const std::optional<flight::UtcTime>& at = photo.photo.captured_at;
    const std::optional<flight::UtcTime>& first = posed.photos.front().photo.captured_at;
    if (at && first) times.times_s.push_back(std::chrono::duration<double>(*at - *first).count());
  }
  const auto does_not_rise =
      std::adjacent_find(times.times_s.begin(), times.times_s.end(), std::greater_equal<>());
  times.are_seconds = times.times_s.size() == posed.photos.size() && does_not_rise == times.times_s.end();
  if (times.are_seconds) return times;
  times.times_s.clear();
  for (std::size_t i = 0; i < posed.photos.size(); ++i) times.times_s.push_back(static_cast<double>(i));
  return times;
}

// Adjusted anew where the positions of all photos are those of other moments. Once more then: what positions
// held too fast before follows. Positions that were given up come back.
Attempt WithoutPositionLag(const ExtractedFlight& extracted, Attempt attempt) {
  constexpr int kRounds = 2;
  const CaptureTimes times = TimesOf(attempt.posed);
  std::vector<PhotoRecord> records = extracted.records;
  double lag_s = 0.0, off_m = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const std::optional<PositionLag> lag = FindPositionLag(attempt.problem, records, times.times_s);
    if (!lag) break;
    lag_s += lag->lag_s;
    TraceDecision("positions shifted",
                  {{times.are_seconds ? "lag_s" : "lag_photos", lag->lag_s}, {"apart_m", lag->median_off_m}});
    off_m = std::max(off_m, lag->median_off_m);
    for (std::size_t i = 0; i < attempt.problem.photos.size(); ++i) {
      if (!records[i].center_in_enu) continue;
      *records[i].center_in_enu += lag->correction_in_enu[i];
      BundlePhoto& photo = attempt.problem.photos[i];
      Eigen::Vector3d recorded = photo.prior_cam_from_enu.TargetOriginInSource();
      recorded.head<2>() = records[i].center_in_enu->head<2>();
      photo.prior_cam_from_enu =
          geo::Rigid3::FromRotationAndTargetOrigin(photo.prior_cam_from_enu.rotation, recorded);
      photo.sigma_position_m.head<2>() = records[i].sigma_m.head<2>();
      photo.has_record = true;
    }
    attempt = Adjusted(std::move(attempt), SettledAdjustment());
  }
  if (lag_s == 0.0) return attempt;
  flight::Remark late{
      lag_s > 0.0 ? flight::RemarkCode::kPositionsOfBefore : flight::RemarkCode::kPositionsOfAfter,
      {{"lag", std::abs(lag_s)},
       {"unit", flight::Remark(times.are_seconds ? flight::RemarkCode::kSecondsApart
                                                 : flight::RemarkCode::kPhotosApart)},
       {"apart_m", off_m}}};
  ByImagesReport& by_images = attempt.report.by_images;
  if (by_images.is_taken) {
    by_images.outcome = flight::Remark{flight::RemarkCode::kImagesPlaced,
                                       {{"photos", by_images.registered},
                                        {"total", records.size()},
                                        {"place", std::vector<flight::Remark>()},
                                        {"height", std::vector<flight::Remark>()}}};
  }
  attempt.report.corrections.push_back(std::move(late));
  return attempt;
}

}  // namespace

Result<Attempt> PlaceByEvidence(const ExtractedFlight& extracted, Attempt by_records,
                                const AlignOptions& options, Progress& progress) {
  const bool may_go_by_images = options.fixed.Photos() == 0 && !extracted.posed.photos.empty();
  std::optional<Attempt> by_images;
  // Where hardly any photo fits to the others, nothing is worth adjusting.
  if (may_go_by_images)
    by_images = TryByImages(extracted, kMaxLostShareByLinks, options, by_records, progress);
  const bool compares = !by_images || !IsNearlyAll(extracted, by_records.report.by_images);
  if (compares) by_records = TiedDirectly(std::move(by_records), options);
  if (progress.IsCancelled()) return AlignmentCancelled();
  progress.Report(0.8, "adjusting");
  if (compares) {
    by_records = AdjustedByRecords(extracted, std::move(by_records), options);
    if (may_go_by_images && !by_records.report.by_images.why)
      by_images = TryByImages(extracted, kMaxLostShare, options, by_records, progress);
  }
  Attempt attempt = by_images
                        ? BetterOf(extracted, std::move(by_records), *std::move(by_images), compares, options)
                        : std::move(by_records);
  if (may_go_by_images) {
    attempt = WithoutPositionLag(extracted, Levelled(extracted, std::move(attempt)));
  }
  if (!attempt.report.by_images.is_taken &&
      LeanedShare(attempt.matched.findings, attempt.problem) > kMuchLeanedShare) {
    attempt = Adjusted(Rematched(std::move(attempt), kMiddlePass, options), FirstAdjustment());
  }
  std::vector<ControlPoint> control = options.control;
  if (attempt.report.by_images.is_taken && attempt.report.by_images.ignores_surveyed_heights) {
    for (ControlPoint& point : control) point.height_m.reset();
  }
  TieToControl(attempt.posed, control, attempt.problem, attempt.report.control);
  if (progress.IsCancelled()) return AlignmentCancelled();
  return attempt;
}

}  // namespace skyquilt::alignment
