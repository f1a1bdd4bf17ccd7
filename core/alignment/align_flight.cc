#include "core/alignment/align_flight.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/alignment/adjustment/bundle_setup.h"
#include "core/alignment/adjustment/tie_to_control.h"
#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/matching/matching_passes.h"
#include "core/alignment/matching/pairs_in_use.h"
#include "core/alignment/registration/correct_poses.h"
#include "core/alignment/registration/direct_registration.h"
#include "core/alignment/registration/flight_lines.h"
#include "core/alignment/registration/place_photos.h"
#include "core/alignment/registration/registration_rounds.h"
#include "core/alignment/second_leg/leg_evidence.h"
#include "core/alignment/second_leg/lost_photos.h"
#include "core/alignment/second_leg/second_leg.h"
#include "core/base/median.h"
#include "core/base/scoped_timer.h"
#include "core/base/try.h"

namespace skyquilt::alignment {
namespace {

constexpr double kReliefCellGsds = 60.0;
constexpr double kGroundSigmas = 3.0;  // largest error of an observation of a point on the ground

// From poses adjusted a first time, where they came from records that were degrees off: a motion over level
// ground fits only part of what two such photos share, so the rest is still to be found.
const MatchingPass kMiddlePass{.min_radius_share = 0.05,
                               .sigmas = 0.0,
                               .max_turn_rad = 0.45,
                               .tolerance_share = 0.015,
                               .min_matches = 8};
constexpr double kMuchLeanedShare = 0.02;  // of a photo's width that a turn of the axis moves its middle by

// From the adjusted poses, on the adjusted relief.
const MatchingPass kLastPass{.min_radius_share = 0.012,
                             .sigmas = 0.0,
                             .max_turn_rad = 0.35,
                             .max_distance_ratio = 0.9,
                             .min_matches = 8,
                             .fit_motion = false};

std::vector<Track> TriangulatedTracks(const std::vector<VerifiedPair>& links, const MatchingInput& input,
                                      const AlignOptions& options) {
  TrackOptions track_options;
  track_options.observations_per_photo = options.observations_per_photo;
  std::vector<Track> tracks = BuildTracks(links, input.features, input.views, track_options);
  std::erase_if(tracks, [&](Track& track) { return !Triangulate(input.views, track); });
  return tracks;
}

// Every match that agrees with the adjusted poses, not only those the adjustment needed: the ground is
// modelled from these.
std::vector<Track> GroundTracks(const std::vector<VerifiedPair>& links, const MatchingInput& input,
                                const AlignOptions& options) {
  TrackOptions track_options;
  track_options.observations_per_photo = options.max_features;
  track_options.splits_contradictory = true;
  std::vector<Track> tracks = BuildTracks(links, input.features, input.views, track_options);
  std::erase_if(tracks, [&](Track& track) {
    // The observation with the largest error goes first, for it pulls the point away from the others.
    while (track.observations.size() >= 2 && Triangulate(input.views, track)) {
      const auto error = [&](const Observation& one) {
        return ReprojectionErrorPx(input.views[one.photo], one, track.point_in_enu) / one.sigma_px;
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

std::vector<Eigen::Vector3d> ReliefPoints(const std::vector<Track>& tracks) {
  constexpr double kUsefulAngleRad = 0.06;
  std::vector<Eigen::Vector3d> points;
  for (const Track& track : tracks) {
    if (track.angle_rad > kUsefulAngleRad) points.push_back(track.point_in_enu);
  }
  return points;
}

double ReliefCellM(const std::vector<View>& views) { return kReliefCellGsds * MedianWidthM(views) / 4000.0; }

// How far the adjustment swung the photos' axes over the ground, in photo widths: half of them further.
double LeanedShare(const std::vector<CorrectedPose>& corrected, const BundleProblem& problem) {
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

// Pairs, and the matches in them, from where the photos now lie.
void Rematch(const poses::PosedFlight& posed, const BundleProblem& problem, const MatchingPass& pass,
             const AlignOptions& options, Relief& relief, MatchingInput& input, MatchedFlight& linked) {
  input.views = ViewsOf(problem);
  relief =
      Relief::FromPoints(ReliefPoints(problem.tracks), ReliefCellM(input.views), posed.ground_z_in_enu_m);
  const std::size_t count = input.views.size();
  linked.pairs = OnlyWithinComponents(SelectPairs(input.views, std::vector<double>(count, 0.0), relief, {}),
                                      linked.links, count);
  linked.links = MatchAndVerify(input, ProjectAllToGround(input, relief, options.threads), linked.pairs, pass,
                                options.threads);
}

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

// Surveyed points further from where the photos agree they are than any survey errs; empty: they fit.
std::string ContradictedControl(const std::vector<ControlReport>& control) {
  constexpr double kNoSurveyM = 0.25;
  std::vector<double> errors_m;
  for (const ControlReport& point : control) {
    if (point.is_used) errors_m.push_back(std::hypot(point.miss_east_m, point.miss_north_m));
  }
  if (errors_m.size() < 3) return {};
  const double median_m = Median(errors_m);
  if (median_m < kNoSurveyM) return {};
  return fmt::format(
      "the surveyed points CONTRADICT the photos: half of the {} used lie {:.1f} m or more from where all photos together "
      "show them. Check the list's coordinates, their zone and the marks",
      errors_m.size(), median_m);
}

constexpr double kOtherFocalSigmas = 3.0;
constexpr double kSigmaFoundFocal = 0.01;

// Of the readable photos, those that may stay lost before the records are doubted as a whole: by links alone,
// when nothing has been adjusted and hardly anything would be worth it, and after everything was tried.
constexpr double kMaxLostShareByLinks = 0.4;
constexpr double kMaxLostShare = 0.1;
constexpr int kMaxLostRounds = 3;
constexpr double kResidualWidthPx = 4000.0;  // of a photo, that residuals are told for

double ResidualAtWidth(double rms_px, const poses::PosedFlight& posed) {
  std::vector<double> widths;
  for (const poses::PosedPhoto& photo : posed.photos) widths.push_back(photo.photo.intrinsics.width_px);
  return rms_px * kResidualWidthPx / Median(std::move(widths));
}

std::optional<SecondLeg> TrySecondLeg(const FirstLeg& first, const LegEvidence& by_records,
                                      double max_lost_share, const AlignOptions& options, AlignReport& report,
                                      Progress& progress) {
  const bool is_asked_for = options.by_images == ByImages::kAlways;
  report.second_leg.why =
      is_asked_for ? "placing by what they show was asked for" : WhyDoubted(by_records, max_lost_share);
  if (report.second_leg.why.empty()) return std::nullopt;
  progress.Report(0.82, "placing photos by what they show");
  // Where residuals are in doubt, as many photos tied are not better by number.
  const bool takes_equal = is_asked_for || by_records.Lost() == 0;
  return PlaceByImages(first, by_records.tied, takes_equal, options.control, options.threads,
                       report.second_leg, progress);
}

// What one leg made of the flight, so that another can be held against it.
struct LegState {
  poses::PosedFlight posed;
  MatchingInput input;
  MatchedFlight linked;
  BundleProblem problem;
  std::vector<CandidatePair> compared;
};

// As if the records had said so.
void GoOnFrom(SecondLeg second, const std::vector<const PhotoFeatures*>& features,
              const std::vector<int>& lines, poses::PosedFlight& posed, MatchingInput& input,
              MatchedFlight& linked, BundleProblem& problem) {
  posed = std::move(second.posed);
  linked.corrected = std::move(second.corrected);
  linked.links = std::move(second.links);
  linked.pairs.clear();
  for (const VerifiedPair& link : linked.links) linked.pairs.push_back({link.first, link.second, 0.0});
  problem = MakeBundle(posed, linked.corrected, lines);
  for (std::size_t c = 0; c < problem.lenses.size(); ++c) {
    BundleLens& lens = problem.lenses[c];
    lens.intrinsics = second.lenses[c];
    // Where the images found another focal length than was recorded, theirs is the one to hold on to: level
    // ground alone says little of it, and heights that are wrong would bend it.
    const double off = std::abs(std::log(lens.intrinsics.focal_x_px / lens.recorded.focal_x_px));
    if (off <= kOtherFocalSigmas * lens.sigma_focal_share) continue;
    lens.recorded.focal_x_px = lens.intrinsics.focal_x_px;
    lens.recorded.focal_y_px = lens.intrinsics.focal_y_px;
    lens.sigma_focal_share = std::max(lens.sigma_focal_share, kSigmaFoundFocal);
  }
  input = MakeMatchingInput(posed);
  input.features = features;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!second.by_images[i]) input.features[i] = nullptr;
    problem.photos[i].has_record = second.has_record[i] != 0;
  }
  input.views = ViewsOf(problem);
}

}  // namespace

FeatureOptions AlignOptions::Features() const {
  FeatureOptions features;
  features.detector_pixels = detector_pixels;
  features.max_features = max_features;
  return features;
}

Result<void> AlignOptions::Validate() const {
  if (threads < 0) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("threads is {}; it must be 0 or more", threads),
                 ""};
  }
  if (detector_pixels < 20'000) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("detector_pixels is {}; it must be at least 20000", detector_pixels), ""};
  }
  if (max_features < 100 || observations_per_photo < 20) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("max_features is {} and observations_per_photo {}; they must be at least 100 and 20",
                    max_features, observations_per_photo),
        ""};
  }
  return {};
}

Result<AlignedFlight> AlignFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                  const AlignOptions& options, AlignReport& report, Progress& progress,
                                  FoundFeatures found) {
  SKYQUILT_TRY(options.Validate());
  const Error cancelled{ErrorCode::kCancelled, "the alignment was cancelled", ""};
  report = {};
  ScopedTimer total_timer(report.total_s);
  std::vector<char> is_unplaced;
  poses::PosedFlight posed = WithUnplaced(recorded, &is_unplaced);
  const std::size_t count = posed.photos.size();
  report.photos = static_cast<int>(count);
  std::vector<std::string> names;
  std::vector<Eigen::Vector2d> places;
  for (const poses::PosedPhoto& photo : posed.photos) {
    names.push_back(photo.photo.name);
    places.push_back(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }

  const Photographed photographed =
      ExtractAll(posed, source, options.Features(), std::move(found), options.threads, 0.7, progress);
  if (progress.IsCancelled()) return cancelled;
  report.photo_reports.resize(count);
  MatchingInput input = MakeMatchingInput(posed);
  const std::vector<const PhotoFeatures*> readable = photographed.Readable();
  input.features = readable;
  for (std::size_t i = 0; i < count; ++i) {
    const PhotoFeatures& features = photographed.features[i];
    report.photo_reports[i].name = names[i];
    report.photo_reports[i].features = static_cast<int>(features.keypoints.size());
    report.decode_s += features.decode_s;
    report.features_s += features.detect_s;
    if (is_unplaced[i]) input.features[i] = nullptr;  // until the second leg places it
  }

  const std::vector<int> lines = FindLines(places);
  Relief relief(posed.ground_z_in_enu_m);
  MatchedFlight linked;
  {
    ScopedTimer timer(report.matching_s);
    progress.Report(0.7, "comparing photos");
    linked = MatchInPasses(posed, lines, input, options.threads, report, progress);
  }
  if (progress.IsCancelled()) return cancelled;
  std::vector<CandidatePair> compared = linked.pairs;
  BundleProblem problem = MakeBundle(posed, linked.corrected, lines);
  if (!options.fixed.empty()) {
    HoldFixed(posed, options.fixed, problem);
    input.views = ViewsOf(problem);
  }
  const std::vector<PhotoRecord> records = RecordsOf(posed, is_unplaced);
  const FirstLeg first_leg{&posed, &is_unplaced, &readable, &records, &problem};
  const bool may_go_by_images = options.fixed.empty() && options.by_images != ByImages::kNever && count > 0;
  std::vector<char> by_images(count, 0);
  bool is_adjusted = false;
  const auto leg_now = [&](const BundleSummary& adjusted) {
    return WeighedLeg{&records,
                      &readable,
                      &is_unplaced,
                      &linked.links,
                      &problem,
                      count > 0 ? ResidualAtWidth(adjusted.rms_px, posed) : 0.0,
                      adjusted.observations,
                      adjusted.dropped,
                      is_adjusted};
  };
  std::optional<SecondLeg> second;
  LegEvidence by_records = Weigh(leg_now({}));
  // Where hardly any photo fits to the others, nothing is worth adjusting.
  if (may_go_by_images)
    second = TrySecondLeg(first_leg, by_records, kMaxLostShareByLinks, options, report, progress);
  const bool compares_legs = !second || !second->is_nearly_all;
  if (compares_legs) {
    ScopedTimer timer(report.matching_s);
    problem.soft_tracks = DirectTracks(input, linked.pairs, linked.links, relief, options.threads);
    report.pairs_by_direct = static_cast<int>(problem.soft_tracks.size());
  }
  if (progress.IsCancelled()) return cancelled;
  {
    ScopedTimer timer(report.adjustment_s);
    progress.Report(0.8, "adjusting");
    BundleOptions first;
    first.cuts_px = {30.0, 10.0};
    first.max_iterations = 15;
    BundleSummary summary;
    const auto adjust = [&](const BundleOptions& bundle_options) {
      problem.tracks = TriangulatedTracks(linked.links, input, options);
      summary = AdjustBundle(problem, bundle_options);
      is_adjusted = true;
      report.iterations += summary.iterations;
    };
    if (compares_legs) {
      adjust(first);
      input.views = ViewsOf(problem);
      relief =
          Relief::FromPoints(ReliefPoints(problem.tracks), ReliefCellM(input.views), posed.ground_z_in_enu_m);
      problem.plane = FitPlane(problem);
      if (RegisterInRounds(posed, relief, options.threads, input, linked, problem) > 0) adjust(first);
      by_records = Weigh(leg_now(summary));
      for (int round = 0; round < kMaxLostRounds && may_go_by_images && HasLost(by_records); ++round) {
        input.views = ViewsOf(problem);
        const std::vector<Track> seen = GroundTracks(linked.links, input, options);
        if (TakeInLost(leg_now(summary), seen, options.threads, posed, input, linked, problem, by_images) ==
            0) {
          break;
        }
        adjust(first);
        by_records = Weigh(leg_now(summary));
      }
      if (may_go_by_images && !second && report.second_leg.why.empty()) {
        second = TrySecondLeg(first_leg, by_records, kMaxLostShare, options, report, progress);
      }
    }
    if (second) {
      std::optional<LegState> kept;
      if (compares_legs && options.by_images != ByImages::kAlways) {
        kept = LegState{posed, input, linked, problem, compared};
      }
      const std::vector<char> placed_by_images = second->by_images;
      report.second_leg.is_placed = second->is_placed;
      GoOnFrom(*std::move(second), readable, lines, posed, input, linked, problem);
      compared = linked.pairs;
      BundleOptions settled = first;
      settled.cuts_px = {10.0};  // they have been adjusted to each other
      settled.max_iterations = 8;
      adjust(settled);
      report.second_leg.is_taken = true;
      if (kept) {
        const LegChoice choice = ChooseLeg(by_records, Weigh(leg_now(summary)));
        report.second_leg.is_taken = choice.takes_images;
        if (!choice.takes_images) {
          report.second_leg.outcome = "not taken: " + choice.why;
          report.second_leg.is_placed = false;
          posed = std::move(kept->posed);
          input = std::move(kept->input);
          linked = std::move(kept->linked);
          problem = std::move(kept->problem);
          compared = std::move(kept->compared);
        }
      }
      if (report.second_leg.is_taken) by_images = placed_by_images;
    }
    for (std::size_t i = 0; i < count; ++i) report.photo_reports[i].is_by_images = by_images[i] != 0;
    if (!report.second_leg.is_taken && LeanedShare(linked.corrected, problem) > kMuchLeanedShare) {
      Rematch(posed, problem, kMiddlePass, options, relief, input, linked);
      adjust(first);
    }
    TieToControl(posed, options.control, problem, report.control);
  }
  if (progress.IsCancelled()) return cancelled;

  // Last matching pass, on the relief, and the last adjustment.
  BundleSummary summary;
  {
    ScopedTimer timer(report.matching_s);
    progress.Report(0.88, "comparing photos once more");
    Rematch(posed, problem, kLastPass, options, relief, input, linked);
    report.pairs_tried = static_cast<int>(linked.pairs.size());
    report.pairs_linked = static_cast<int>(linked.links.size());
  }
  {
    ScopedTimer timer(report.adjustment_s);
    progress.Report(0.92, "adjusting");
    ReweighPriors(problem);
    problem.plane = FitPlane(problem);
    problem.tracks = TriangulatedTracks(linked.links, input, options);
    BundleOptions last;
    last.estimate_lens_sigma = count <= 200;
    summary = AdjustBundle(problem, last);
    report.iterations += summary.iterations;
  }
  if (report.second_leg.why.empty()) {
    const LegEvidence held = Weigh(leg_now(summary));
    report.second_leg.outcome = fmt::format(
        "the recorded poses hold: {} of {} photos are tied together from them", held.tied, held.readable);
  }
  const std::vector<PhotoDoubt> doubts = DoubtPhotos(input, compared, linked.links, relief);
  report.corrections = DescribeCorrections(linked.corrected, names, lines);
  report.pairs = PairsInUse(problem, names);
  ReportControl(problem, report.control);
  report.position_bias_m = problem.position_bias_m;
  report.tie_points = static_cast<int>(problem.tracks.size());
  report.observations = summary.observations;
  report.observations_dropped = summary.dropped;
  report.residual_rms_px = summary.rms_px;
  report.solver = summary.solver;
  ReportLenses(posed, problem, report);
  input.views = ViewsOf(problem);
  const std::vector<Track> ground_tracks = GroundTracks(linked.links, input, options);
  AlignedFlight flight = PlacePhotos(
      {&posed, &problem, &ground_tracks, &linked.corrected, &doubts, &photographed.unreadable}, report);
  SKYQUILT_TRY(SettleUnplaced(recorded, flight, report));
  if (std::string words = report.second_leg.is_taken ? SecondLegInWords(report.second_leg)
                                                     : ContradictionInWords(Weigh(leg_now(summary)));
      !words.empty()) {
    flight.warnings.insert(flight.warnings.begin(), std::move(words));
  }
  if (std::string words = DroppedInWords(report.observations, report.observations_dropped); !words.empty()) {
    flight.warnings.insert(flight.warnings.begin(), std::move(words));
  }
  if (std::string words = ContradictedControl(report.control); !words.empty()) {
    flight.warnings.insert(flight.warnings.begin(), std::move(words));
  }
  for (const ControlReport& point : report.control) {
    if (!point.is_used) {
      flight.warnings.push_back(
          fmt::format("ground control point {} is not used: it {}", point.name, point.reason));
    }
  }
  flight.warnings.insert(flight.warnings.end(), report.corrections.begin(), report.corrections.end());
  progress.Report(1.0, "aligned");
  return flight;
}

}  // namespace skyquilt::alignment
