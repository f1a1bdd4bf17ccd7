#include "core/alignment/attempts/lost_photos.h"

#include <algorithm>
#include <utility>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/attempts/register_lost.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr double kMaxLostShare = 0.3;

// A position that is as far off as this counts for nothing in what is said of the map.
bool IsSaidToBeFar(const flight::Photo& photo, const Eigen::Vector3d& center, const geo::LocalFrame& frame) {
  constexpr double kFarM = 1000.0;
  return photo.position &&
         !((frame.EnuAtHeight(photo.position->position, center.z()) - center).head<2>().norm() < kFarM);
}

// A photo without record: its pose is where it was found, give or take much.
CorrectedPose PlaceUnrecorded(const geo::Rigid3& cam_from_enu, double ground_z_m,
                              const geo::LocalFrame& frame, poses::PosedPhoto& photo) {
  photo.cam_from_enu = cam_from_enu;
  photo.height_above_ground_m = std::max(0.5, cam_from_enu.TargetOriginInSource().z() - ground_z_m);
  const double unknown_m = kUnknownShare * photo.height_above_ground_m;
  photo.covariance.setZero();
  photo.covariance_with_next.setZero();
  photo.clock_sigma_s = 0.0;
  photo.covariance.diagonal() << Eigen::Vector3d::Constant(kSigmaTurnRad * kSigmaTurnRad),
      Eigen::Vector3d::Constant(unknown_m * unknown_m);
  photo.error_radius_m = unknown_m;
  CorrectedPose corrected;
  corrected.start_cam_from_enu = corrected.prior_cam_from_enu = cam_from_enu;
  corrected.notes = {flight::RemarkCode::kPlacedWithoutRecord};
  corrected.position_was_wrong = IsSaidToBeFar(photo.photo, cam_from_enu.TargetOriginInSource(), frame);
  return corrected;
}

}  // namespace

bool HasLost(const AttemptEvidence& evidence) {
  if (evidence.Lost() == 0 || evidence.tied < 2) return false;
  // What a map that stays holds is sound, however many are new beside it.
  const double most = std::max(1.0, kMaxLostShare * static_cast<double>(evidence.readable));
  return evidence.has_fixed || static_cast<double>(evidence.Lost()) <= most;
}

int TakeInLost(const WeighedAttempt& attempt, const std::vector<Track>& tracks, const Relief& relief,
               int threads, poses::PosedFlight& posed, MatchingInput& input, MatchedFlight& linked,
               BundleProblem& problem) {
  const PhotoSet tied = TiedPhotos(attempt);
  const std::vector<RegisteredLost> found =
      RegisterLost({attempt.features, &input.views, &tied, &tracks, attempt.records, &relief}, threads);
  if (found.empty()) return 0;
  // Where the images placed the others, its record counts as little as theirs, and that is said of all of
  // them.
  const bool is_common = 2 * std::count_if(problem.photos.begin(), problem.photos.end(),
                                           [](const BundlePhoto& one) { return one.is_by_images; }) >
                         static_cast<std::ptrdiff_t>(problem.photos.size());
  const std::vector<GroundPrior> recorded = MakeGroundPriors(posed, MakeMatchingInput(posed));
  for (const RegisteredLost& one : found) {
    const int i = one.photo;
    std::erase_if(linked.links,
                  [&](const VerifiedPair& link) { return link.first == i || link.second == i; });
    linked.links.insert(linked.links.end(), one.links.begin(), one.links.end());
    if (problem.photos[i].is_fixed) continue;  // it stays, and holds those that it is tied to
    TraceDecision("lost photo registered", {{"photo", i}, {"tied_to", one.links.size()}},
                  posed.photos[i].photo.name);
    const bool is_unrecorded = is_common || (*attempt.records)[i].is_unplaced;
    linked.corrected[i] = is_unrecorded ? PlaceUnrecorded(one.cam_from_enu, posed.ground_z_in_enu_m,
                                                          posed.frame, posed.photos[i])
                                        : CorrectToPose(posed.photos[i], recorded[i], one.cam_from_enu);
    if (is_common) linked.corrected[i].notes.clear();
    problem.photos[i] =
        MakeBundlePhoto(posed.photos[i], linked.corrected[i], problem.photos[i].lens, problem.photos[i].line);
    problem.photos[i].has_record = !is_unrecorded;
    problem.photos[i].is_by_images = true;
    // Points are looked for about as deep as the photo was high: by what it shows, whatever was recorded.
    problem.photos[i].height_above_ground_m =
        std::max(0.5, one.cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m);
    input.features[i] = (*attempt.features)[i];
    input.views[i].cam_from_enu = one.cam_from_enu;
    input.views[i].height_above_ground_m = problem.photos[i].height_above_ground_m;
  }
  return static_cast<int>(found.size());
}

}  // namespace skyquilt::alignment
