#include "core/alignment/attempts/attempt_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/alignment/matching/verified_pair.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

using flight::Remark;
using flight::RemarkCode;

constexpr std::size_t kMinFeatures = 150;      // a photo with fewer shows hardly anything
constexpr double kMinContradictionM = 1.0;     // less is no reason to place a flight in another way
constexpr double kMinOffClaimM = 0.1;          // from antenna to camera; no claim is held to less
constexpr double kMinContradictionRad = 0.17;  // ten degrees between optical axes
constexpr std::size_t kMinPositions = 5;       // for a verdict on all of them
constexpr double kPoorResidualPx = 5.0;        // after a first adjustment, which keeps errors of up to 10
constexpr double kGoodResidualPx = 1.5;
constexpr double kMaxResidualGrowth = 1.5;
// A flight with good records drops up to two fifths, one whose rolling shutter is not known three.
constexpr double kMaxDroppedShare = 0.7;
constexpr double kFarBetter = 0.5;
constexpr double kMaxMoreContradicted = 0.1;  // of the photos
// So many more photos tied together outweigh whatever the records say.
constexpr double kManyTimesMore = 1.5;

double Share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

bool AreMostOf(std::size_t positions, std::size_t contradicted) {
  return positions >= kMinPositions && 2 * contradicted > positions;
}

}  // namespace

double AttemptEvidence::DroppedShare() const {
  if (is_adjusted && observations == 0) return 1.0;
  return Share(dropped, observations + dropped);
}
bool AttemptEvidence::ContradictsPositions() const { return AreMostOf(positions, positions_contradicted); }
double AttemptEvidence::PositionsContradicted() const { return Share(positions_contradicted, positions); }
double AttemptEvidence::AttitudesContradicted() const { return Share(attitudes_contradicted, attitudes); }

bool ShowsEnough(const PhotoFeatures* features) {
  return features && features->keypoints.size() >= kMinFeatures;
}

PhotoSet TiedPhotos(const Attempt& attempt) {
  const std::size_t count = attempt.problem.photos.size();
  std::vector<int> seen(count, 0);
  for (const Track& track : attempt.problem.tracks) {
    for (const Observation& one : track.observations) ++seen[one.photo];
  }
  const bool by_links = attempt.problem.tracks.empty();
  std::vector<std::vector<int>> components(1);  // the first: of a map that stays
  for (std::vector<int>& members : FindConnectedComponents(count, attempt.matched.links).members) {
    const bool is_of_map = std::any_of(members.begin(), members.end(),
                                       [&](int i) { return attempt.problem.photos[i].is_fixed; });
    if (is_of_map) {
      components.front().insert(components.front().end(), members.begin(), members.end());
    } else {
      components.push_back(std::move(members));
    }
  }
  PhotoSet largest(count);
  for (const std::vector<int>& members : components) {
    PhotoSet tied(count);
    for (const int i : members) {
      if (by_links || seen[i] >= kEnoughObservations) tied.Add(i);
    }
    if (tied.Count() > largest.Count()) largest = std::move(tied);
  }
  return largest;
}

double MedianWidthPx(const poses::PosedFlight& posed) {
  return MedianOf(posed.photos, [](const poses::PosedPhoto& one) { return one.photo.intrinsics.width_px; });
}

AttemptEvidence Weigh(const ExtractedFlight& extracted, const Attempt& attempt) {
  AttemptEvidence evidence;
  if (!attempt.posed.photos.empty())
    evidence.residual_rms_px = attempt.adjusted.rms_px * kReferenceWidthPx / MedianWidthPx(attempt.posed);
  evidence.observations = attempt.adjusted.observations;
  evidence.dropped = attempt.adjusted.dropped;
  evidence.is_adjusted = attempt.is_adjusted;
  evidence.has_fixed = std::any_of(attempt.problem.photos.begin(), attempt.problem.photos.end(),
                                   [](const BundlePhoto& photo) { return photo.is_fixed; });
  const PhotoSet tied = TiedPhotos(attempt);
  std::vector<double> errors_m, errors_sigmas;
  for (std::size_t i = 0; i < tied.Photos(); ++i) {
    if (!tied.Has(i) && !ShowsEnough(extracted.readable[i])) continue;
    ++evidence.readable;
    if (!tied.Has(i)) {
      evidence.unplaced += extracted.records[i].is_unplaced ? 1 : 0;
      continue;
    }
    ++evidence.tied;
    const PhotoRecord& record = extracted.records[i];
    const geo::Rigid3& pose = attempt.problem.photos[i].cam_from_enu;
    if (record.center_in_enu) {
      const Eigen::Vector3d error = pose.TargetOriginInSource() - *record.center_in_enu -
                                    attempt.problem.position_bias_m -
                                    attempt.problem.clock_error_s * attempt.problem.photos[i].by_clock_mps;
      errors_m.push_back(error.head<2>().norm());
      errors_sigmas.push_back(errors_m.back() / std::max(1e-3, record.sigma_m.x()));
      ++evidence.positions;
      evidence.positions_contradicted +=
          errors_m.back() > std::max(kMinContradictionM, kContradictedSigmas * record.sigma_m.x()) ? 1 : 0;
      evidence.positions_off_claim +=
          errors_m.back() > std::max(kMinOffClaimM, kContradictedSigmas * record.sigma_m.x()) ? 1 : 0;
    }
    if (record.cam_from_enu) {
      const Eigen::Vector3d recorded = record.cam_from_enu->conjugate() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d found = pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const double apart_rad = std::atan2(recorded.cross(found).norm(), recorded.dot(found));
      ++evidence.attitudes;
      evidence.attitudes_contradicted +=
          apart_rad > std::max(kMinContradictionRad, kContradictedSigmas * record.sigma_tilt_rad) ? 1 : 0;
    }
  }
  if (!errors_m.empty()) {
    evidence.median_error_m = Median(std::move(errors_m));
    evidence.median_error_sigmas = Median(std::move(errors_sigmas));
  }
  return evidence;
}

std::optional<flight::Remark> WhyDoubted(const AttemptEvidence& evidence, double max_lost_share) {
  if (evidence.readable < 3) return std::nullopt;
  const double max_lost = std::max(1.0, max_lost_share * static_cast<double>(evidence.readable));
  // Where no photo at all is tied, one that nothing places is one too many.
  if (evidence.unplaced > 0 && (evidence.tied == 0 || static_cast<double>(evidence.Lost()) > max_lost) &&
      2 * evidence.unplaced >= evidence.Lost()) {
    return Remark{RemarkCode::kRecordsUnplaced,
                  {{"photos", evidence.unplaced}, {"total", evidence.readable}}};
  }
  if (static_cast<double>(evidence.Lost()) > max_lost)
    return Remark{RemarkCode::kRecordsLost, {{"photos", evidence.Lost()}, {"total", evidence.readable}}};
  if (evidence.residual_rms_px > kPoorResidualPx)
    return Remark{RemarkCode::kRecordsDisagree, {{"apart_px", evidence.residual_rms_px}}};
  if (evidence.is_adjusted && evidence.observations == 0) return Remark{RemarkCode::kRecordsNoPoint};
  if (evidence.DroppedShare() > kMaxDroppedShare) {
    return Remark{RemarkCode::kRecordsFewPoints,
                  {{"used", evidence.observations}, {"points", evidence.observations + evidence.dropped}}};
  }
  // As of heights that are wrong by a factor: the photos fit each other at any size.
  if (evidence.ContradictsPositions()) {
    return Remark{RemarkCode::kRecordsElsewhere,
                  {{"photos", evidence.positions_contradicted}, {"total", evidence.positions}}};
  }
  return std::nullopt;
}

std::optional<flight::Remark> WhyImagesLose(const AttemptEvidence& by_records,
                                            const AttemptEvidence& by_images) {
  const bool keeps_far_more = by_records.DroppedShare() > kMaxDroppedShare &&
                              by_images.DroppedShare() < kFarBetter * by_records.DroppedShare();
  const bool fits_far_better =
      keeps_far_more || (by_images.residual_rms_px < kFarBetter * by_records.residual_rms_px &&
                         by_records.residual_rms_px > kPoorResidualPx);
  const bool agrees_far_better =
      by_records.ContradictsPositions() &&
      by_images.PositionsContradicted() < kFarBetter * by_records.PositionsContradicted();
  const bool ties_more = by_images.tied > by_records.tied;
  if (!ties_more && !((fits_far_better || agrees_far_better) && by_images.tied == by_records.tied)) {
    return Remark{RemarkCode::kImagesTie, {{"photos", by_images.tied}, {"by_records", by_records.tied}}};
  }
  // (A residual of nothing is that of no adjustment.)
  const double max_residual_px =
      by_records.residual_rms_px > 0.0
          ? std::max(kGoodResidualPx, kMaxResidualGrowth * by_records.residual_rms_px)
          : kPoorResidualPx;
  if (by_images.residual_rms_px > max_residual_px) {
    return Remark{RemarkCode::kImagesDisagree,
                  {{"apart_px", by_images.residual_rms_px}, {"by_records_px", by_records.residual_rms_px}}};
  }
  const bool ties_far_more = static_cast<double>(by_images.tied) >=
                             kManyTimesMore * static_cast<double>(std::max<std::size_t>(1, by_records.tied));
  // Poses to which hardly anything fits agree with their records because they were not moved from them.
  if (ties_far_more || keeps_far_more) return std::nullopt;
  const auto off = [&](RemarkCode code, auto contradicted, auto of) {
    return Remark{code,
                  {{"photos", by_images.*contradicted},
                   {"total", by_images.*of},
                   {"by_records", by_records.*contradicted},
                   {"of_records", by_records.*of}}};
  };
  if (by_images.PositionsContradicted() > by_records.PositionsContradicted() + kMaxMoreContradicted)
    return off(RemarkCode::kImagesOffPositions, &AttemptEvidence::positions_contradicted,
               &AttemptEvidence::positions);
  if (by_images.AttitudesContradicted() > by_records.AttitudesContradicted() + kMaxMoreContradicted)
    return off(RemarkCode::kImagesOffAngles, &AttemptEvidence::attitudes_contradicted,
               &AttemptEvidence::attitudes);
  return std::nullopt;
}

std::optional<flight::Remark> ContradictionOf(const AttemptEvidence& evidence) {
  if (!AreMostOf(evidence.positions, evidence.positions_off_claim)) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kPositionsContradict,
                        {{"photos", evidence.positions},
                         {"apart_m", evidence.median_error_m},
                         {"times", evidence.median_error_sigmas}}};
}

std::optional<flight::Remark> DroppedOf(int observations, int dropped) {
  const int all = observations + dropped;
  if (all == 0 || dropped <= kMaxDroppedShare * all) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kPointsDropped, {{"used", observations}, {"points", all}}};
}

}  // namespace skyquilt::alignment
