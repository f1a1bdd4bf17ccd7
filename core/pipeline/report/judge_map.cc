#include "core/pipeline/report/judge_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "core/alignment/bundle/control_points.h"
#include "core/alignment/matching/verified_pair.h"
#include "core/alignment/scene/photo_set.h"
#include "core/flight/aside/aside.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/report/positions_error.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::Placement;
using Eigen::Vector2d;

constexpr double kSurveySigmaM = 0.02;  // of surveyed points, each axis
constexpr double kMarkSigmaPx = 0.5;    // of a mark by hand, each axis
constexpr double kLikelyExcess = 2.0;   // five points' variance exceeds this share of the true one in 1 of 20
constexpr double kFarOffM = 10.0;       // what a receiver of a phone or a drone is good for
constexpr double kBeyondStated = 1.0 - 0.683;  // of places, outside a stated radius
// Surveyed points that tell of all of a map: so many, and so spread that they hold its places, in the mean,
// as well as a point holds its own.
constexpr std::size_t kFewestOfAll = 3;
constexpr double kLeverOfAll = 1.0;

// What placed the map, or all that is known of it is where it lies against them.
struct ControlFit {
  std::vector<Vector2d> places;  // as surveyed
  double system_error_m = 0.0;   // the worst of the points' systems
  double expected_square = 0.0;  // of survey and marks, one axis; sums over all points
  double residual_square = 0.0;
  double product = 0.0;  // of what a point is missed by with and without it: expected to be its variance
  int predicted = 0;
};

Vector2d PlaceOf(const JudgedMap& map, const alignment::ControlReport& point) {
  return map.flight.frame.EnuAtHeight(point.surveyed, 0.0).head<2>();
}

Vector2d MissOf(const alignment::ControlReport& point) { return {point.miss_east_m, point.miss_north_m}; }

// Of survey and marks, one axis.
double ExpectedSquareM2(const JudgedMap& map, const alignment::ControlReport& point) {
  return kSurveySigmaM * kSurveySigmaM +
         std::pow(kMarkSigmaPx * map.photo_gsd_m, 2) / std::max(1, point.sightings);
}

ControlFit FitOf(const JudgedMap& map) {
  ControlFit fit;
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (!point.is_used || point.is_check) continue;
    fit.places.push_back(PlaceOf(map, point));
    fit.system_error_m = std::max(fit.system_error_m, point.system_error_m.value_or(0.0));
    fit.expected_square += ExpectedSquareM2(map, point);
    const Vector2d miss = MissOf(point);
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
  if (map.is_forecast || IsTiedToSurvey(map)) return false;
  const bool is_by_images = map.alignment != nullptr && map.alignment->by_images.is_taken;
  if (is_by_images) return map.alignment->by_images.is_scale_guessed.value_or(false);
  return map.poses.is_height_guessed.value_or(false) && !IsAnyAligned(map) && map.poses.photos_by_log < 2 &&
         PositionsOf(map).records.size() < 2;
}

bool IsNorthGuessed(const JudgedMap& map) {
  return !IsTiedToSurvey(map) && map.alignment != nullptr && map.alignment->by_images.is_taken &&
         map.alignment->by_images.is_north_guessed.value_or(false);
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

std::optional<AbsoluteAccuracy> ByControl(const JudgedMap& map) {
  if (map.alignment == nullptr) return std::nullopt;
  const ControlFit fit = FitOf(map);
  if (fit.places.size() < 2) return std::nullopt;  // one has nothing to be checked against
  const double sigma_m = std::hypot(SigmaByControlM(map, fit), fit.system_error_m / kCircleSigmas);
  return StatedRadius(sigma_m, AbsoluteSupport::kControlPoints, fit.places.size());
}

bool TellOfAll(const JudgedMap& map, const std::vector<Vector2d>& surveyed) {
  return surveyed.size() >= kFewestOfAll && LeverOf(map, surveyed) <= kLeverOfAll;
}

// Photos of groups that none of the points is marked in, whether it places the map or checks it.
alignment::PhotoSet BesideSurvey(const JudgedMap& map, const TiedGroups& groups) {
  alignment::PhotoSet none(groups.of_photo.size());
  std::set<int> surveyed;
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (!point.is_used) continue;
    if (point.marks.empty()) return none;  // of maps that do not say where it is marked
    for (const alignment::ControlMarkReport& mark : point.marks) {
      if (mark.is_used) surveyed.insert(groups.OfPhotoNamed(mark.photo));
    }
  }
  alignment::PhotoSet beside = none;
  for (std::size_t i = 0; i < groups.of_photo.size(); ++i) {
    if (groups.of_photo[i] >= 0 && !surveyed.contains(groups.of_photo[i])) beside.Add(i);
  }
  return beside;
}

// Photos of groups whose positions lack corrections where most of the flight's have them, or the reverse.
alignment::PhotoSet OfOtherReceivers(const JudgedMap& map, const TiedGroups& groups) {
  std::vector<const flight::RecordedPosition*> all;
  std::map<int, std::vector<const flight::RecordedPosition*>> of_group;
  for (std::size_t i = 0; i < groups.of_photo.size(); ++i) {
    const auto& position = map.flight.photos[i].photo.position;
    if (groups.of_photo[i] < 0 || !position || position->is_repeated) continue;
    all.push_back(&*position);
    of_group[groups.of_photo[i]].push_back(&*position);
  }
  const bool is_corrected = poses::CommonErrorOf(all).is_corrected;
  std::set<int> others;
  for (const auto& [group, positions] : of_group) {
    if (poses::CommonErrorOf(positions).is_corrected != is_corrected) others.insert(group);
  }
  alignment::PhotoSet of_others(groups.of_photo.size());
  for (std::size_t i = 0; i < groups.of_photo.size(); ++i) {
    if (others.contains(groups.of_photo[i])) of_others.Add(i);
  }
  return of_others;
}

// The share of places that lie within a radius where another one is stated of them.
double ShareWithin(double radius_m, double stated_m) {
  return 1.0 - std::exp(-0.5 * std::pow(kCircleSigmas * radius_m / stated_m, 2));
}

// Of a map of two parts: within the radius lie as many of its places as within that of each of its own.
AbsoluteAccuracy OfTwoParts(const AbsoluteAccuracy& one, const AbsoluteAccuracy& other,
                            double share_of_other) {
  constexpr int kHalvings = 60;
  const auto radius_m = [](const AbsoluteAccuracy& part) {
    constexpr double kUnknownM = 1e7;
    return part.sigma_m.value_or(kUnknownM);
  };
  const bool is_other_worse = radius_m(other) > radius_m(one);
  const AbsoluteAccuracy& better = is_other_worse ? one : other;
  const AbsoluteAccuracy& worse = is_other_worse ? other : one;
  const double share = is_other_worse ? share_of_other : 1.0 - share_of_other;  // of the worse
  const double stated = ShareWithin(1.0, 1.0);
  AbsoluteAccuracy both = 1.0 - share < stated ? worse : better;
  if (!both.sigma_m) return both;
  double low_m = radius_m(better), high_m = radius_m(worse);
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle_m = 0.5 * (low_m + high_m);
    const double within = (1.0 - share) * ShareWithin(middle_m, radius_m(better)) +
                          share * ShareWithin(middle_m, radius_m(worse));
    (within < stated ? low_m : high_m) = middle_m;
  }
  both.sigma_m = OfTwoDigits(high_m);
  return both;
}

// Of some of its photos, by their positions.
AbsoluteAccuracy ByPositionsOf(const alignment::PhotoSet& some, bool is_of_the_others, const JudgedMap& map) {
  alignment::AlignedFlight part = map.flight;
  std::size_t number = 0;
  std::erase_if(part.photos, [&](const AlignedPhoto&) { return some.Has(number++) == is_of_the_others; });
  return ByPositions({.flight = part, .poses = map.poses, .alignment = map.alignment});
}

// `as_one`: as if all of the map hung together.
AbsoluteAccuracy OfGroups(const JudgedMap& map, const AbsoluteAccuracy& as_one) {
  if (map.alignment == nullptr || map.alignment->components < 2 || map.is_by_hand || map.is_forecast)
    return as_one;
  const TiedGroups groups = GroupsByTies(map.flight.photos, map.alignment->pairs);
  const bool is_surveyed = !IsByReceiver(as_one);
  const alignment::PhotoSet beside = is_surveyed ? BesideSurvey(map, groups) : OfOtherReceivers(map, groups);
  if (beside.Count() == 0) return as_one;
  const auto aligned =
      std::count_if(map.flight.photos.begin(), map.flight.photos.end(),
                    [](const AlignedPhoto& photo) { return photo.placement == Placement::kAligned; });
  return OfTwoParts(is_surveyed ? as_one : ByPositionsOf(beside, true, map),
                    ByPositionsOf(beside, false, map),
                    static_cast<double>(beside.Count()) / static_cast<double>(aligned));
}

// What places the map, whatever it is checked by.
AbsoluteAccuracy WithoutChecks(const JudgedMap& map) {
  if (const auto by_control = ByControl(map)) return OfGroups(map, *by_control);
  if (map.is_by_hand) return {std::nullopt, AbsoluteSupport::kHand, 0};
  AbsoluteAccuracy by_positions = ByPositions(map);
  if (IsByReceiver(by_positions)) by_positions = OfGroups(map, by_positions);
  if (IsScaleGuessed(map) || IsNorthGuessed(map)) by_positions.sigma_m.reset();
  return by_positions;
}

// By how much few points widen what they are missed by: as the radius that holds its share of all places does
// where the sigma of both axes is known of these points alone, by Fisher's F with 2 and 2 n degrees of
// freedom. 1.37 of one, 1.10 of three, 1 of very many.
double FewPointsWiden(double count) {
  return std::sqrt(count * (std::pow(kBeyondStated, -1.0 / count) - 1.0) / -std::log(kBeyondStated));
}

// Checks near one place show the shift that positions share, not what turns, scales and bends the map.
double ElsewhereToo(const JudgedMap& map, double at_checks_m, const AbsoluteAccuracy& placed) {
  if (!IsByReceiver(placed) || !IsAnyAligned(map) || AreContradicted(map, placed))
    return std::max(at_checks_m, *placed.sigma_m);
  return std::hypot(at_checks_m, kCircleSigmas * ErrorOfPositions(map, PositionsOf(map)).shape_m);
}

// `placed`: what is stated without them.
std::optional<AbsoluteAccuracy> ByChecks(const JudgedMap& map, const AbsoluteAccuracy& placed) {
  if (map.alignment == nullptr) return std::nullopt;
  std::vector<Vector2d> places;
  double missed_m2 = 0.0;  // of both axes together, as surveyors state what a map misses its check points by
  double expected_m2 = 0.0;     // of which survey and marks leave so much, however well they are met
  double system_error_m = 0.0;  // of which points in the same system know nothing
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (!point.is_used || !point.is_check) continue;
    places.push_back(PlaceOf(map, point));
    missed_m2 += MissOf(point).squaredNorm();
    expected_m2 += 2.0 * ExpectedSquareM2(map, point);
    system_error_m = std::max(system_error_m, point.system_error_m.value_or(0.0));
  }
  if (places.empty()) return std::nullopt;
  const auto count = static_cast<double>(places.size());
  const double off_m = FewPointsWiden(count) * std::sqrt(std::max(missed_m2, expected_m2) / count);
  double radius_m = std::hypot(off_m, system_error_m);
  if (!TellOfAll(map, places)) {
    if (!placed.sigma_m) return std::nullopt;
    radius_m = ElsewhereToo(map, radius_m, placed);
  }
  return AbsoluteAccuracy{OfTwoDigits(radius_m), AbsoluteSupport::kCheckPoints,
                          static_cast<int>(places.size())};
}

AbsoluteAccuracy AbsoluteOf(const JudgedMap& map) {
  if (!map.is_placed) return {};
  const AbsoluteAccuracy placed = WithoutChecks(map);
  const std::optional<AbsoluteAccuracy> by_checks = ByChecks(map, placed);
  return by_checks ? OfGroups(map, *by_checks) : placed;
}

// What the photos may contradict: what is stated, and the positions where the survey tells of a part.
AbsoluteAccuracy Contradictable(const JudgedMap& map, const AbsoluteAccuracy& absolute) {
  if (absolute.by != AbsoluteSupport::kControlPoints && absolute.by != AbsoluteSupport::kCheckPoints)
    return absolute;
  std::vector<Vector2d> surveyed;
  for (const alignment::ControlReport& point : map.alignment->control) {
    if (point.is_used) surveyed.push_back(PlaceOf(map, point));
  }
  return map.is_by_hand || TellOfAll(map, surveyed) ? absolute : ByPositions(map);
}

MapLimit MissedChecks(const JudgedMap& map) {
  MapLimit missed{LimitKind::kChecksMissed};
  const std::vector<std::optional<double>> allowed_m = MissesAllowedM(map);
  for (std::size_t k = 0; k < allowed_m.size(); ++k) {
    if (!allowed_m[k]) continue;
    ++missed.of;
    if (MissOf(map.alignment->control[k]).norm() > *allowed_m[k]) ++missed.count;
  }
  return missed;
}

RelativeAccuracy RelativeOf(const JudgedMap& map, bool is_scale_guessed) {
  RelativeAccuracy relative;
  if (map.alignment == nullptr || map.gsd_m <= 0.0) return relative;
  if (render::TellOfMap(map.seams)) {
    relative = {map.seams.median_m, map.seams.median_m / map.gsd_m, RelativeSupport::kSeams,
                map.seams.reliable};
  } else if (map.alignment->tie_points > 0) {
    const double error_m = map.alignment->residual_rms_px * map.photo_gsd_m;
    relative = {error_m, error_m / map.gsd_m, RelativeSupport::kTiePoints, map.alignment->tie_points};
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
  const int left_out = static_cast<int>(
      std::count_if(map.flight.left_out.begin(), map.flight.left_out.end(),
                    [](const flight::LeftOutPhoto& photo) { return !flight::LeavesNoGap(photo); }));
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
  if (AreContradicted(map, Contradictable(map, absolute)))
    limits.push_back({LimitKind::kPositionsContradicted});
  if (absolute.sigma_m && *absolute.sigma_m > kFarOffM) limits.push_back({LimitKind::kFarOff});
  if (const auto apart = RecordsApartOfControl(map); apart && apart->IsContradiction())
    limits.push_back({LimitKind::kControlContradicted});
  if (const MapLimit missed = MissedChecks(map); missed.count > 0) limits.push_back(missed);
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

std::vector<flight::Remark> RemarksOnPositions(const JudgedMap& map) {
  const AbsoluteAccuracy absolute = AbsoluteOf(map);
  if (!IsByReceiver(Contradictable(map, absolute))) return {};
  const PositionsError error = ErrorOfPositions(map, PositionsOf(map));
  std::vector<flight::Remark> remarks;
  // All of the map leans: one surveyed point shows it.
  if (IsByReceiver(absolute) && error.lean.off_m > error.common_m) {
    remarks.push_back({flight::RemarkCode::kLeanOpen,
                       {{"positions", absolute.count},
                        {"lean_deg", geo::RadToDeg(error.lean.sigma_rad)},
                        {"off_m", OfTwoDigits(kCircleSigmas * error.lean.off_m)}}});
  }
  if (error.jump) {
    remarks.push_back({flight::RemarkCode::kPositionsJump,
                       {{"before", error.jump->before},
                        {"after", error.jump->after},
                        {"by_m", OfTwoDigits(error.jump->by_m)}}});
  }
  if (error.height_jump) {
    remarks.push_back({flight::RemarkCode::kHeightsJump,
                       {{"before", error.height_jump->before},
                        {"after", error.height_jump->after},
                        {"by_m", OfTwoDigits(error.height_jump->by_m)}}});
  }
  return remarks;
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

std::vector<std::optional<double>> MissesAllowedM(const JudgedMap& map) {
  if (map.alignment == nullptr) return {};
  const std::vector<alignment::ControlReport>& points = map.alignment->control;
  std::vector<std::optional<double>> allowed_m(points.size());
  if (!map.is_placed) return allowed_m;
  const AbsoluteAccuracy placed = WithoutChecks(map);
  if (!placed.sigma_m) return allowed_m;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!points[k].is_used || !points[k].is_check) continue;
    // Surveyed points that place the map are of the same system.
    const double system_m = IsByReceiver(placed) ? points[k].system_error_m.value_or(0.0) : 0.0;
    const double sigma_m = std::hypot(std::hypot(*placed.sigma_m, system_m) / kCircleSigmas,
                                      std::sqrt(ExpectedSquareM2(map, points[k])));
    allowed_m[k] = std::max(alignment::kNoSurveyM, kCheckSigmas * sigma_m);
  }
  return allowed_m;
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

int TiedGroups::OfPhotoNamed(const std::string& name) const {
  const auto found = photos.find(name);
  return found == photos.end() ? -1 : of_photo[static_cast<std::size_t>(found->second)];
}

TiedGroups GroupsByTies(const std::vector<AlignedPhoto>& photos,
                        const std::vector<alignment::AlignPairReport>& pairs) {
  TiedGroups groups;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].placement == Placement::kAligned)
      groups.photos.emplace(photos[i].photo.name, static_cast<int>(i));
  }
  std::vector<alignment::PhotoPair> ties;
  for (const alignment::AlignPairReport& pair : pairs) {
    const auto first = groups.photos.find(pair.first), second = groups.photos.find(pair.second);
    if (!pair.is_by_direct && first != groups.photos.end() && second != groups.photos.end())
      ties.push_back({first->second, second->second, {}, {}, 0.0});
  }
  alignment::ConnectedComponents components = alignment::FindConnectedComponents(photos.size(), ties);
  groups.of_photo = std::move(components.of_photo);
  groups.count = static_cast<int>(components.members.size());
  return groups;
}

void TellPhotos(const MapQuality& quality, alignment::AlignedFlight& flight) {
  if (!quality.absolute.sigma_m || quality.absolute.by == AbsoluteSupport::kHand) return;
  for (AlignedPhoto& photo : flight.photos) {
    if (photo.placement == Placement::kAligned) photo.error_radius_m = *quality.absolute.sigma_m;
  }
}

alignment::ErrorsKnown ErrorsKnownOf(const AbsoluteAccuracy& absolute) {
  if (absolute.sigma_m) return alignment::ErrorsKnown::kOfAll;
  const bool is_recorded = absolute.by != AbsoluteSupport::kNone && absolute.by != AbsoluteSupport::kHand;
  return is_recorded ? alignment::ErrorsKnown::kOfPoseOnly : alignment::ErrorsKnown::kOfNone;
}

}  // namespace skyquilt::pipeline
