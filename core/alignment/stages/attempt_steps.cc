#include "core/alignment/stages/attempt_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/bundle/control_points.h"
#include "core/alignment/bundle/find_readout.h"
#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/gyro_lag.h"
#include "core/alignment/from_records/matching_passes.h"
#include "core/alignment/scene/tracks.h"
#include "core/base/process/large_blocks_apart.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr double kExtractedFraction = 0.7;  // of the alignment's progress
constexpr double kReliefCellGsds = 60.0;
constexpr double kGroundSigmas = 3.0;  // largest error of an observation of a point on the ground

constexpr std::size_t kManyPhotos = 500;

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

// From the adjusted poses, on the adjusted relief.
const MatchingPass kLastPass{.min_radius_share = 0.012,
                             .sigmas = 0.0,
                             .max_turn_rad = 0.35,
                             .max_distance_ratio = 0.9,
                             .min_matches = 8,
                             .fit_motion = false};

constexpr int kMaxUnbent = 4;                        // adjustments of positions whose claims turn out false
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
  found = Adjusted(std::move(found), bundle_options);
  const std::vector<int> rolling = LensesThatRoll(found.problem, lenses);
  TraceDecision("rolling shutter looked for", {{"lenses", lenses.size()}, {"found", rolling.size()}});
  if (rolling.size() < lenses.size()) {
    attempt.report.iterations = found.report.iterations;
    return attempt;
  }
  // What was matched by photos taken for still ones is matched anew.
  found = Adjusted(Rematched(std::move(found), kLastPass, options), bundle_options);
  for (const int lens : rolling) {
    int photos = 0;
    std::string camera;
    for (std::size_t i = 0; i < found.problem.photos.size(); ++i) {
      if (found.problem.photos[i].lens != lens || !may_roll.Has(i)) continue;
      ++photos;
      camera = found.posed.photos[i].photo.model;
    }
    found.report.corrections.push_back({flight::RemarkCode::kRollingShutterFound,
                                        {{"camera", camera.empty() ? "The camera" : camera},
                                         {"readout_ms", 1e3 * std::abs(found.problem.lenses[lens].readout_s)},
                                         {"photos", photos}}});
  }
  return found;
}

// Where nothing but reckoning says how far the flight went, recorded heights say it better: the ground lies
// as high as the place of take-off, so that the map cannot grow or shrink with the reckoned way.
std::optional<BundlePlane> PlaneOf(const Attempt& attempt) {
  std::optional<BundlePlane> plane = FitPlane(attempt.problem);
  const std::vector<poses::PosedPhoto>& photos = attempt.posed.photos;
  const bool is_reckoned = std::all_of(photos.begin(), photos.end(), [](const poses::PosedPhoto& photo) {
    return photo.position_source.empty() && !photo.photo.position;
  });
  if (plane && is_reckoned && attempt.problem.control.empty())
    plane->height_m = attempt.posed.ground_z_in_enu_m;
  return plane;
}

}  // namespace

Attempt Adjusted(Attempt attempt, const BundleOptions& options) {
  if (attempt.matched.views.size() >= kManyPhotos) ReturnFreedMemory();  // the matcher's, before the solver's
  {
    ScopedTimer timer(attempt.report.adjustment_s);
    attempt.problem.tracks = {};  // not both at a time
    attempt.problem.tracks =
        BuildTracks(attempt.matched.links, attempt.matched.features, attempt.matched.views, {});
    std::erase_if(attempt.problem.tracks,
                  [&](Track& track) { return !Triangulate(attempt.matched.views, track); });
    attempt.adjusted = AdjustBundle(attempt.problem, options);
  }
  TraceDecision("adjusted", {{"points", attempt.problem.tracks.size()},
                             {"observations", attempt.adjusted.observations},
                             {"dropped", attempt.adjusted.dropped},
                             {"residual_px", attempt.adjusted.rms_px},
                             {"iterations", attempt.adjusted.iterations}});
  attempt.report.iterations += attempt.adjusted.iterations;
  attempt.is_adjusted = true;
  return attempt;
}

Relief AdjustedRelief(const Attempt& attempt) {
  const double cell_m = kReliefCellGsds * MedianWidthM(attempt.matched.views) / kReferenceWidthPx;
  return Relief::FromPoints(PointsWithHeights(attempt.problem.tracks), cell_m,
                            attempt.posed.ground_z_in_enu_m);
}

Attempt Rematched(Attempt attempt, const MatchingPass& pass, const AlignOptions& options) {
  MatchedFlight& matched = attempt.matched;
  const std::size_t count = matched.views.size();
  {
    ScopedTimer timer(attempt.report.matching_s);
    matched.views = ViewsOf(attempt.problem);
    attempt.relief = AdjustedRelief(attempt);
    matched.pairs = OnlyWithinComponents(
        SelectPairs(matched.views, std::vector<double>(count, 0.0), attempt.relief), matched.links, count);
    matched.links = {};  // not both at a time
    matched.links = MatchAndVerify(matched, ProjectAllToGround(matched, attempt.relief, options.threads),
                                   pass, options.threads);
  }
  TraceDecision("compared again", {{"pairs", matched.pairs.size()}, {"verified", matched.links.size()}});
  return attempt;
}

std::vector<Track> GroundTracks(const Attempt& attempt) {
  const std::vector<View>& views = attempt.matched.views;
  std::vector<Track> tracks =
      BuildTracks(attempt.matched.links, attempt.matched.features, views,
                  {.observations_per_photo = kMaxFoundKeypoints, .splits_contradictory = true});
  std::erase_if(tracks, [&](Track& track) { return !TriangulateAgreed(views, kGroundSigmas, track); });
  return tracks;
}

Error AlignmentCancelled() { return {ErrorCode::kCancelled, "the alignment was cancelled", ""}; }

Result<ExtractedFlight> ExtractFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                      const AlignOptions& options, FoundFeatures found, Progress& progress) {
  ExtractedFlight extracted = WithUnplaced(recorded);
  extracted.features =
      ExtractAll(extracted.posed, source, std::move(found), options.threads, kExtractedFraction, progress);
  if (progress.IsCancelled()) return AlignmentCancelled();
  for (std::size_t i = 0; i < extracted.features.size(); ++i) {
    const PhotoFeatures& one = extracted.features[i];
    extracted.readable.push_back(one.unreadable.empty() ? &one : nullptr);
    TraceDecision(extracted.readable[i] ? "photo read" : "photo unreadable",
                  {{"photo", i}, {"keypoints", one.keypoints.size()}}, extracted.posed.photos[i].photo.name);
  }
  extracted.gyros = TieGyrosToRows(extracted.posed, extracted.readable, options.threads);
  extracted.lines = FindLines(EastNorthOf(extracted.posed.photos));
  return extracted;
}

Result<Attempt> MatchByRecords(const ExtractedFlight& extracted, const AlignOptions& options,
                               Progress& progress) {
  const std::size_t count = extracted.posed.photos.size();
  Attempt attempt;
  attempt.posed = extracted.posed;
  attempt.relief = Relief(attempt.posed.ground_z_in_enu_m);
  attempt.matched = MakeMatchedFlight(attempt.posed);
  attempt.matched.features = extracted.readable;
  for (std::size_t i = 0; i < count; ++i) {
    if (extracted.records[i].is_unplaced) attempt.matched.features[i] = nullptr;  // until the images place it
    const poses::PosedPhoto& photo = attempt.posed.photos[i];
    if (photo.photo.turning) attempt.matched.views[i].readout_motion = ReadoutMotion(photo, 0);
  }
  {
    ScopedTimer timer(attempt.report.matching_s);
    progress.Report(0.7, "comparing photos");
    attempt.report.rejected_pairs =
        MatchInPasses(attempt.posed, extracted.lines, attempt.matched, options.threads, progress);
  }
  if (progress.IsCancelled()) return AlignmentCancelled();
  TraceDecision("compared by records", {{"pairs", attempt.matched.pairs.size()},
                                        {"verified", attempt.matched.links.size()},
                                        {"refused", attempt.report.rejected_pairs.size()}});
  attempt.compared = attempt.matched.pairs;
  attempt.problem = MakeBundle(attempt.posed, attempt.matched.findings, extracted.lines);
  for (std::size_t i = 0; i < count; ++i) {
    // A guessed place says nothing of how good the recorded ones are, and is no better for those that are.
    const PhotoRecord& record = extracted.records[i];
    if (!record.is_unplaced && !record.center_in_enu) attempt.problem.photos[i].has_record = false;
  }
  if (options.fixed.Photos() > 0) {
    HoldFixed(attempt.posed, options.fixed, attempt.problem);
    attempt.matched.views = ViewsOf(attempt.problem);
  }
  return attempt;
}

Attempt FinishAttempt(Attempt attempt, const AlignOptions& options, Progress& progress) {
  progress.Report(0.88, "comparing photos once more");
  attempt = Rematched(std::move(attempt), kLastPass, options);
  progress.Report(0.92, "adjusting");
  bool is_bent = ReweighPriors(attempt.problem);
  attempt.problem.plane = PlaneOf(attempt);
  const BundleOptions last{.estimate_lens_sigma = attempt.problem.photos.size() <= kMaxPhotosForLensSigma};
  attempt = Adjusted(std::move(attempt), last);
  for (int round = 1; is_bent && round < kMaxUnbent; ++round) {
    is_bent = ReweighPositions(attempt.problem);
    attempt.problem.plane = PlaneOf(attempt);
    attempt = Adjusted(std::move(attempt), last);
  }
  attempt = WithReadoutFound(std::move(attempt), last, options);
  if (BelieveContradictedControlLess(attempt.problem)) attempt = Adjusted(std::move(attempt), last);
  return attempt;
}

}  // namespace skyquilt::alignment
