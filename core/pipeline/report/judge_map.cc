#include "core/pipeline/report/judge_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/median.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/report/open_lean.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::Placement;
using Eigen::Vector2d;

constexpr double kCircleSigmas = 1.515;  // sqrt(-2 ln(1 - 0.683))
constexpr double kSurveySigmaM = 0.02;   // of surveyed points, each axis
constexpr double kMarkSigmaPx = 0.5;     // of a mark by hand, each axis
constexpr double kLikelyExcess = 2.0;  // five points' variance exceeds this share of the true one in 1 of 20
constexpr int kFreedomOfMove = 4;      // shift, turn and scale
constexpr std::size_t kFewestPositions = 3;  // for turn and scale, and a miss that shows
constexpr double kFewPositionsShare = 0.1;
// Of many photos: among four, one wrong position shows without being told from the others; five name it, and
// a second one hides it.
constexpr std::size_t kHandful = 5;
// So many refuted positions are no accident of single records: what bends a map refutes them too.
constexpr double kManyRefutedShare = 0.2;
constexpr std::size_t kFewestAgreeing = 3;
constexpr double kAgreeingShare = 0.1;       // of all positions
constexpr double kApartOfShift = 1.0 / 3.0;  // two shifts that are one, apart from the noise of receivers
// Of what all photos may share that recorded no angles: a body's by its log, or any.
constexpr double kAngleOfLogDeg = 2.0, kAngleOfNothingDeg = 5.0;
constexpr double kFarOffM = 10.0;  // what a receiver of a phone or a drone is good for
constexpr int kFewestSeams = 5;

bool IsAnyAligned(const JudgedMap& map) {
  return std::any_of(map.flight.photos.begin(), map.flight.photos.end(),
                     [](const AlignedPhoto& photo) { return photo.placement == Placement::kAligned; });
}

// Where none is aligned each lies by its own record.
bool IsJudged(const JudgedMap& map, const AlignedPhoto& photo) {
  return map.is_forecast || map.alignment == nullptr || photo.placement == Placement::kAligned ||
         !IsAnyAligned(map);
}

std::vector<Vector2d> JudgedCameras(const JudgedMap& map) {
  std::vector<Vector2d> cameras;
  for (const AlignedPhoto& photo : map.flight.photos) {
    if (IsJudged(map, photo)) cameras.emplace_back(photo.cam_from_enu.TargetOriginInSource().head<2>());
  }
  return cameras;
}

struct SupportingPositions {
  std::vector<Vector2d> places;  // of the cameras, as the map has them
  std::vector<Vector2d> misses;  // recorded minus that
  std::vector<const flight::RecordedPosition*> records;
  std::vector<Vector2d> refuted;  // as `misses`, of those that place nothing
};

// Of photos that count; a position that the pictures refute places nothing.
SupportingPositions PositionsOf(const JudgedMap& map) {
  std::set<std::string> refuted;
  if (map.alignment != nullptr) {
    for (const alignment::AlignPhotoReport& photo : map.alignment->photo_reports) {
      const auto& faults = photo.faults;
      if (std::find(faults.begin(), faults.end(), alignment::PhotoFault::kPositionWrong) != faults.end())
        refuted.insert(photo.name);
    }
  }
  SupportingPositions positions;
  for (const AlignedPhoto& photo : map.flight.photos) {
    if (!photo.photo.position || photo.photo.position->is_repeated || !IsJudged(map, photo)) continue;
    const Eigen::Vector3d camera = photo.cam_from_enu.TargetOriginInSource();
    const Eigen::Vector3d recorded = map.flight.frame.EnuAtHeight(photo.photo.position->position, camera.z());
    if (refuted.contains(photo.photo.name)) {
      const Vector2d miss = (recorded - camera).head<2>();
      if (miss.allFinite()) positions.refuted.push_back(miss);
      continue;
    }
    positions.places.emplace_back(camera.head<2>());
    positions.misses.emplace_back((recorded - camera).head<2>());
    positions.records.push_back(&*photo.photo.position);
  }
  return positions;
}

double SquareM2(const std::vector<Vector2d>& misses) {
  double square = 0.0;
  for (const Vector2d& miss : misses) square += miss.squaredNorm();
  return square;
}

// Of each axis; nothing to learn from fewer positions than a move has freedom.
double NoiseM(const std::vector<Vector2d>& misses) {
  const int freedom = 2 * static_cast<int>(misses.size()) - kFreedomOfMove;
  return freedom <= 0 ? 0.0 : std::sqrt(SquareM2(misses) / freedom);
}

// 1/n + how much more than the positions' own the map spreads about their middle.
double LeverOf(const JudgedMap& map, const std::vector<Vector2d>& places) {
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& place : places) middle += place / static_cast<double>(places.size());
  double of_positions = 0.0, of_map = 0.0;
  for (const Vector2d& place : places) of_positions += (place - middle).squaredNorm();
  const std::vector<Vector2d> cameras = JudgedCameras(map);
  for (const Vector2d& camera : cameras) of_map += (camera - middle).squaredNorm();
  const double mean_of_map = cameras.empty() ? 0.0 : of_map / static_cast<double>(cameras.size());
  constexpr double kOnOnePlaceM2 = 1.0;
  return 1.0 / static_cast<double>(places.size()) + mean_of_map / std::max(kOnOnePlaceM2, of_positions);
}

double MedianRadiusM(const JudgedMap& map) {
  std::vector<double> radii_m;
  for (const AlignedPhoto& photo : map.flight.photos) radii_m.push_back(photo.error_radius_m);
  return MedianIfAny(std::move(radii_m)).value_or(0.0);
}

// Without alignment every photo has its own error, its angles' on the ground with it.
double OwnErrorM(const JudgedMap& map) {
  return map.is_forecast || IsAnyAligned(map) ? 0.0 : MedianRadiusM(map);
}

AbsoluteAccuracy StatedRadius(double sigma_of_axis_m, AbsoluteSupport by, std::size_t count) {
  return {OfTwoDigits(kCircleSigmas * sigma_of_axis_m), by, static_cast<int>(count)};
}

// Of both axes together, as surveyors state what a map misses its check points by; nothing without points.
std::optional<double> HorizontalRmsM(const std::vector<Vector2d>& misses) {
  if (misses.empty()) return std::nullopt;
  return std::sqrt(SquareM2(misses) / static_cast<double>(misses.size()));
}

// What placed the map, or all that is known of it is where it lies against them.
struct ControlFit {
  std::vector<Vector2d> places;  // as surveyed
  double system_error_m = 0.0;   // the worst of the points' systems
  double expected_square = 0.0;  // of survey and marks, one axis; sums over all points
  double residual_square = 0.0;
  double product = 0.0;  // of what a point is missed by with and without it: expected to be its variance
  int predicted = 0;
};

ControlFit FitOf(const JudgedMap& map) {
  ControlFit fit;
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (!point.is_used || point.is_check) continue;
    fit.places.emplace_back(map.flight.frame.EnuAtHeight(point.surveyed, 0.0).head<2>());
    fit.system_error_m = std::max(fit.system_error_m, point.system_error_m.value_or(0.0));
    fit.expected_square +=
        kSurveySigmaM * kSurveySigmaM + std::pow(kMarkSigmaPx * map.gsd_m, 2) / std::max(1, point.sightings);
    const Vector2d miss{point.miss_east_m, point.miss_north_m};
    fit.residual_square += miss.squaredNorm();
    if (!point.left_out) continue;
    fit.product += miss.dot(Vector2d{point.left_out->miss_east_m, point.left_out->miss_north_m});
    ++fit.predicted;
  }
  return fit;
}

// Two surveyed points say how large the map is and how it is turned, whatever its records say.
bool IsTiedToSurvey(const JudgedMap& map) {
  return map.alignment != nullptr && FitOf(map).places.size() >= 2;
}

// Nothing recorded says how large the map is: neither where two photos were taken nor how high.
bool IsScaleGuessed(const JudgedMap& map) {
  if (map.is_by_hand || map.is_forecast || IsTiedToSurvey(map)) return false;
  const bool is_by_images = map.alignment != nullptr && map.alignment->by_images.is_taken;
  if (is_by_images) return map.alignment->by_images.is_scale_guessed.value_or(false);
  return map.poses.is_height_guessed.value_or(false) && !IsAnyAligned(map) && map.poses.photos_by_log < 2 &&
         PositionsOf(map).records.size() < 2;
}

bool IsNorthGuessed(const JudgedMap& map) {
  return !map.is_by_hand && !IsTiedToSurvey(map) && map.alignment != nullptr &&
         map.alignment->by_images.is_taken && map.alignment->by_images.is_north_guessed.value_or(false);
}

// Survey and marks average out over the points, by as much as they span the map. What the points are missed
// by beyond that is the map's own shape, which they do not average out.
double SigmaByControlM(const JudgedMap& map, const ControlFit& fit) {
  const double count = static_cast<double>(fit.places.size());
  const double expected = fit.expected_square / count;
  const double freedom = 2.0 * count - kFreedomOfMove;
  const double seen = fit.predicted > 0 ? fit.product / (2.0 * fit.predicted)
                      : freedom > 0.0   ? fit.residual_square / freedom
                                        : 0.0;
  // What they are plainly missed by. Two points that miss are not turned and scaled to fit: a shift is all
  // that they share.
  const double missed = fit.residual_square / (2.0 * (freedom > 0.0 ? count : count - 1.0));
  const double square = std::max({expected, seen, missed});
  const double averaging = std::min(square, kLikelyExcess * expected);
  return std::sqrt(averaging * LeverOf(map, fit.places) + square - averaging);
}

std::optional<AbsoluteAccuracy> BySurvey(const JudgedMap& map) {
  if (map.alignment == nullptr) return std::nullopt;
  std::vector<Vector2d> checks;
  double system_error_m = 0.0;  // of which points in the same system know nothing
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (!point.is_used || !point.is_check) continue;
    checks.emplace_back(point.miss_east_m, point.miss_north_m);
    system_error_m = std::max(system_error_m, point.system_error_m.value_or(0.0));
  }
  if (const auto rms_m = HorizontalRmsM(checks))
    return AbsoluteAccuracy{OfTwoDigits(std::hypot(*rms_m, system_error_m)), AbsoluteSupport::kCheckPoints,
                            static_cast<int>(checks.size())};
  const ControlFit fit = FitOf(map);
  if (fit.places.size() < 2) return std::nullopt;  // one has nothing to be checked against
  const double sigma_m = std::hypot(SigmaByControlM(map, fit), fit.system_error_m / kCircleSigmas);
  return StatedRadius(sigma_m, AbsoluteSupport::kControlPoints, fit.places.size());
}

// Turn and scale of the others hang on them. A handful is enough where it is half of the photos.
bool AreFewPositions(std::size_t count, std::size_t placed) {
  const bool is_handful = count <= kHandful && 2 * count < placed;
  return count < placed && (count < kFewestPositions || is_handful ||
                            static_cast<double>(count) < kFewPositionsShare * static_cast<double>(placed));
}

std::size_t CountByLog(const JudgedMap& map) {
  return static_cast<std::size_t>(std::max(0, map.poses.photos_by_log));
}

bool IsPlacedByLog(const JudgedMap& map, const SupportingPositions& positions) {
  const std::size_t by_log = CountByLog(map);
  return map.poses.log_position_sigma_m &&
         (2 * by_log >= JudgedCameras(map).size() || by_log >= positions.records.size());
}

// Of the positions of photos or of a log, each axis.
struct ErrorOfPositions {
  double common_m = 0.0;  // with what their scatter leaves
  bool is_corrected = false;
  OpenLean lean;  // beside it; photos that lie by their records count their angles already
};

ErrorOfPositions ErrorOfLog(const JudgedMap& map) {
  const double noise_m = map.alignment == nullptr ? 0.0 : map.alignment->position_residual_m / std::sqrt(2.0);
  const std::vector<Vector2d> cameras = JudgedCameras(map);
  const auto count = static_cast<double>(std::max<std::size_t>(1, std::min(CountByLog(map), cameras.size())));
  const double sigma_m = map.poses.log_position_sigma_m.value_or(0.0);
  ErrorOfPositions error{
      std::hypot(sigma_m, noise_m * std::sqrt(2.0 / count)), map.poses.log_is_corrected, {}};
  if (OwnErrorM(map) <= 0.0)
    error.lean = OpenLeanOf(map.flight, cameras, map.is_forecast ? sigma_m : noise_m, kAngleOfLogDeg);
  return error;
}

ErrorOfPositions ErrorOf(const JudgedMap& map, const SupportingPositions& positions) {
  if (IsPlacedByLog(map, positions)) return ErrorOfLog(map);
  const poses::CommonError common = poses::CommonErrorOf(positions.records);
  const bool is_own = OwnErrorM(map) > 0.0;
  const double noise_m = map.is_forecast || is_own ? 0.0 : NoiseM(positions.misses);
  // What claims to be corrected and scatters by far more is something else, of which nobody knows how much of
  // its error is common to all of them.
  const bool is_false_claim = common.is_corrected && noise_m > poses::kFalseClaim * common.sigma_m;
  const double of_noise_m = is_false_claim ? noise_m : noise_m * std::sqrt(LeverOf(map, positions.places));
  ErrorOfPositions error{std::hypot(common.sigma_m, of_noise_m), common.is_corrected && !is_false_claim, {}};
  const double apart_m = map.is_forecast ? common.sigma_m : noise_m;
  if (!is_own) error.lean = OpenLeanOf(map.flight, positions.places, apart_m, kAngleOfNothingDeg);
  return error;
}

AbsoluteAccuracy ByPositions(const JudgedMap& map) {
  const double own_m = OwnErrorM(map) / kCircleSigmas;
  const std::size_t placed = JudgedCameras(map).size(), by_log = CountByLog(map);
  const SupportingPositions positions = PositionsOf(map);
  const bool is_by_log = IsPlacedByLog(map, positions);
  // Reckoned from a given place: each photo says how far that may have led it astray.
  if (!is_by_log && positions.records.empty() && by_log > 0)
    return {OfTwoDigits(MedianRadiusM(map)), AbsoluteSupport::kHand, static_cast<int>(by_log)};
  if (!is_by_log && positions.records.empty()) return {};
  const ErrorOfPositions error = ErrorOf(map, positions);
  const AbsoluteSupport by = error.is_corrected ? AbsoluteSupport::kRtk : AbsoluteSupport::kGnss;
  // Of the places on the track nobody knows which are the photos'.
  if (is_by_log && map.poses.time_sigma_s.value_or(0.0) >= poses::kOpenClockSigmaS)
    return {std::nullopt, by, 0};
  const std::size_t count = is_by_log ? std::min(by_log, placed) : positions.records.size();
  if (count == 0 || AreFewPositions(count, placed)) return {std::nullopt, by, static_cast<int>(count)};
  // Two sources of places that contradict each other: nobody knows which of them is wrong.
  const double doubt_m = is_by_log ? 0.0 : map.poses.lists_contradict_m.value_or(0.0);
  return StatedRadius(std::max({own_m, doubt_m, std::hypot(error.common_m, error.lean.off_m)}), by, count);
}

// Where most or many are, the photos that the map follows may be the wrong ones.
bool AreManyRefuted(const SupportingPositions& positions) {
  const std::size_t count = positions.refuted.size();
  const double all = static_cast<double>(count + positions.records.size());
  if (static_cast<double>(count) > kManyRefutedShare * all) return true;
  if (count < kFewestAgreeing) return false;
  const Vector2d shift = MedianByAxis(positions.refuted);
  const auto agreeing = static_cast<std::size_t>(std::count_if(
      positions.refuted.begin(), positions.refuted.end(),
      [&](const Vector2d& miss) { return (miss - shift).norm() < kApartOfShift * shift.norm(); }));
  return agreeing >= kFewestAgreeing && static_cast<double>(agreeing) >= kAgreeingShare * all;
}

// What the map misses all of them by, of each axis: which are right is not known, so it does not average out.
// A map that is bent has no photo further off than it is long; a record further away is of another place.
double SpreadWithRefutedM(const JudgedMap& map, const SupportingPositions& positions) {
  const std::vector<Vector2d> cameras = JudgedCameras(map);
  double length_m = 0.0;
  for (const Vector2d& camera : cameras) length_m = std::max(length_m, (camera - cameras.front()).norm());
  std::vector<Vector2d> misses = positions.misses;
  for (const Vector2d& miss : positions.refuted)
    misses.push_back(miss * std::min(1.0, length_m / std::max(1e-3, miss.norm())));
  return NoiseM(misses);
}

// The warning that says that most positions are missed by far more than they claim; null: they agree.
const flight::Remark* ContradictionIn(const std::vector<flight::Remark>& remarks) {
  for (const flight::Remark& remark : remarks) {
    if (remark.code == flight::RemarkCode::kPositionsContradict ||
        remark.code == flight::RemarkCode::kImagesAgainstPositions)
      return &remark;
    for (const auto& [name, value] : remark.values) {
      const auto* within = std::get_if<std::vector<flight::Remark>>(&value.is);
      const flight::Remark* found = within != nullptr ? ContradictionIn(*within) : nullptr;
      if (found != nullptr) return found;
    }
  }
  return nullptr;
}

// What that warning says the map as a whole may be off by.
double MayBeOffM(const flight::Remark* contradiction) {
  if (contradiction == nullptr || contradiction->code != flight::RemarkCode::kPositionsContradict) return 0.0;
  const auto value = contradiction->values.find("apart_m");
  if (value == contradiction->values.end()) return 0.0;
  if (const double* apart_m = std::get_if<double>(&value->second.is)) return *apart_m;
  const std::int64_t* whole_m = std::get_if<std::int64_t>(&value->second.is);  // read from JSON
  return whole_m != nullptr ? static_cast<double>(*whole_m) : 0.0;
}

bool IsByReceiver(const AbsoluteAccuracy& absolute) {
  return absolute.sigma_m && (absolute.by == AbsoluteSupport::kGnss || absolute.by == AbsoluteSupport::kRtk);
}

// The photos contradict what claims to say how far off the map is.
bool AreContradicted(const JudgedMap& map, const AbsoluteAccuracy& absolute) {
  return IsByReceiver(absolute) &&
         (ContradictionIn(map.flight.warnings) != nullptr || AreManyRefuted(PositionsOf(map)));
}

AbsoluteAccuracy WithContradictions(const JudgedMap& map, AbsoluteAccuracy absolute) {
  if (!IsByReceiver(absolute)) return absolute;
  const SupportingPositions positions = PositionsOf(map);
  double radius_m = std::max(*absolute.sigma_m, MayBeOffM(ContradictionIn(map.flight.warnings)));
  if (AreManyRefuted(positions))
    radius_m = std::hypot(radius_m, kCircleSigmas * SpreadWithRefutedM(map, positions));
  absolute.sigma_m = OfTwoDigits(radius_m);
  return absolute;
}

AbsoluteAccuracy AbsoluteOf(const JudgedMap& map) {
  if (!map.is_placed) return {};
  if (const auto surveyed = BySurvey(map)) return *surveyed;
  if (map.is_by_hand) return {std::nullopt, AbsoluteSupport::kHand, 0};
  AbsoluteAccuracy by_positions = WithContradictions(map, ByPositions(map));
  if (IsScaleGuessed(map) || IsNorthGuessed(map)) by_positions.sigma_m.reset();
  return by_positions;
}

RelativeAccuracy RelativeOf(const JudgedMap& map, bool is_scale_guessed) {
  RelativeAccuracy relative;
  if (map.alignment == nullptr || map.gsd_m <= 0.0) return relative;
  if (map.seams.reliable >= kFewestSeams) {
    relative = {map.seams.median_m, map.seams.median_m / map.gsd_m, RelativeSupport::kSeams,
                map.seams.reliable};
  } else if (map.alignment->tie_points > 0) {
    const double error_px = map.alignment->residual_rms_px;
    relative = {error_px * map.gsd_m, error_px, RelativeSupport::kTiePoints, map.alignment->tie_points};
  } else {
    return relative;
  }
  relative.error_px = OfTwoDigits(*relative.error_px);
  relative.error_m = OfTwoDigits(*relative.error_m);
  if (is_scale_guessed) relative.error_m.reset();
  return relative;
}

// A log's positions are gone by now but for what the points moved them by.
std::optional<poses::RecordsApart> ApartByLog(const JudgedMap& map) {
  if (!map.poses.log_position_sigma_m || map.poses.photos_by_log < static_cast<int>(kFewestPositions))
    return std::nullopt;
  return poses::AgainstRecords(map.alignment->position_bias_m.head<2>(),
                               {map.poses.log_is_corrected, *map.poses.log_position_sigma_m});
}

std::vector<MapLimit> LimitsOf(const JudgedMap& map, const AbsoluteAccuracy& absolute) {
  std::vector<MapLimit> limits;
  const int placed = static_cast<int>(map.flight.photos.size());
  const int left_out = static_cast<int>(map.flight.left_out.size());
  if (!map.is_placed) limits.push_back({LimitKind::kNotGeoreferenced});
  // None at all where the pictures refute each that there is.
  const bool is_guessed = IsScaleGuessed(map), is_north_guessed = IsNorthGuessed(map);
  const bool is_placed_by_few = map.is_placed && !absolute.sigma_m && absolute.by != AbsoluteSupport::kHand &&
                                !is_guessed && !is_north_guessed;
  const bool is_told = map.alignment != nullptr && map.alignment->by_images.is_taken && !is_guessed;
  if (is_guessed ||
      (map.is_by_images && !is_told && (!map.is_placed || (is_placed_by_few && absolute.count < 2))))
    limits.push_back({LimitKind::kScaleGuessed});
  if (is_north_guessed) limits.push_back({LimitKind::kNorthGuessed});
  if (is_placed_by_few) limits.push_back({LimitKind::kFewPositions, absolute.count, placed});
  if (AreContradicted(map, absolute)) limits.push_back({LimitKind::kPositionsContradicted});
  if (absolute.sigma_m && *absolute.sigma_m > kFarOffM) limits.push_back({LimitKind::kFarOff});
  if (const auto apart = RecordsApartOfControl(map); apart && apart->IsContradiction())
    limits.push_back({LimitKind::kControlContradicted});
  if (absolute.by == AbsoluteSupport::kHand && !absolute.sigma_m)
    limits.push_back({LimitKind::kPlacedByHand});
  if (left_out > 0) limits.push_back({LimitKind::kLeftOut, left_out, placed + left_out});
  if (map.is_forecast) return limits;
  const int pose_only = static_cast<int>(
      std::count_if(map.flight.photos.begin(), map.flight.photos.end(),
                    [](const AlignedPhoto& photo) { return photo.placement == Placement::kPoseOnly; }));
  if (pose_only == placed && placed > 1) {
    limits.push_back({LimitKind::kNoneAligned, pose_only, placed});
  } else if (pose_only > 0 && placed > 1) {
    limits.push_back({LimitKind::kPoseOnly, pose_only, placed});
  }
  return limits;
}

}  // namespace

std::optional<flight::Remark> RemarkOnLean(const JudgedMap& map) {
  const AbsoluteAccuracy absolute = AbsoluteOf(map);
  if (!IsByReceiver(absolute)) return std::nullopt;
  const ErrorOfPositions error = ErrorOf(map, PositionsOf(map));
  if (error.lean.off_m <= error.common_m) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kLeanOpen,
                        {{"positions", absolute.count},
                         {"lean_deg", geo::RadToDeg(error.lean.sigma_rad)},
                         {"off_m", OfTwoDigits(kCircleSigmas * error.lean.off_m)}}};
}

MapQuality JudgeMap(const JudgedMap& map) {
  MapQuality quality;
  quality.absolute = AbsoluteOf(map);
  quality.limits = LimitsOf(map, quality.absolute);
  quality.relative = RelativeOf(map, quality.IsLimitedBy(LimitKind::kScaleGuessed));
  quality.status = !map.is_placed ? MapStatus::kUnplaced
                   : quality.IsLimitedBy(LimitKind::kFewPositions) ||
                           quality.IsLimitedBy(LimitKind::kScaleGuessed) ||
                           quality.IsLimitedBy(LimitKind::kNorthGuessed)
                       ? MapStatus::kDoubtful
                   : quality.limits.empty() ? MapStatus::kReady
                                            : MapStatus::kLimited;
  return quality;
}

std::optional<poses::RecordsApart> RecordsApartOfControl(const JudgedMap& map) {
  if (map.alignment == nullptr || !map.is_placed || FitOf(map).places.empty()) return std::nullopt;
  const SupportingPositions positions = PositionsOf(map);
  std::vector<poses::RecordedResidual> residuals;
  for (std::size_t k = 0; k < positions.records.size(); ++k)
    residuals.push_back({positions.misses[k], positions.records[k]});
  const auto apart = poses::RecordsApartOf(residuals);
  return apart ? apart : ApartByLog(map);
}

void TellPhotos(const MapQuality& quality, alignment::AlignedFlight& flight) {
  if (!quality.absolute.sigma_m || quality.absolute.by == AbsoluteSupport::kHand) return;
  for (AlignedPhoto& photo : flight.photos) {
    if (photo.placement == Placement::kAligned) photo.error_radius_m = *quality.absolute.sigma_m;
  }
}

}  // namespace skyquilt::pipeline
