#include "core/pipeline/report/positions_error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>
#include <variant>

#include "core/base/median.h"
#include "core/flight/remarks/remark.h"
#include "core/pipeline/report/judge_map.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/evidence/position_jump.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedPhoto;
using alignment::Placement;
using Eigen::Vector2d;
using Eigen::Vector3d;

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
constexpr double kUpOfSide = 2.0;  // what a receiver errs by in height, of what it does sideways

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

// Of each axis; nothing to learn from fewer positions than a move has freedom.
double NoiseM(const std::vector<Vector2d>& misses) {
  const int freedom = 2 * static_cast<int>(misses.size()) - kFreedomOfMove;
  double square_m2 = 0.0;
  for (const Vector2d& miss : misses) square_m2 += miss.squaredNorm();
  return freedom <= 0 ? 0.0 : std::sqrt(square_m2 / freedom);
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

// Of cameras that the pictures place.
std::optional<JumpOfPositions> JumpIn(const SupportingPositions& positions, double claimed_m) {
  std::vector<std::size_t> in_order(positions.photos.size());
  std::iota(in_order.begin(), in_order.end(), std::size_t{0});
  std::stable_sort(in_order.begin(), in_order.end(), [&](std::size_t a, std::size_t b) {
    return positions.photos[a]->captured_at < positions.photos[b]->captured_at;
  });
  std::vector<Vector2d> misses;
  for (const std::size_t k : in_order) misses.push_back(positions.misses[k]);
  const std::optional<poses::PositionJump> jump = poses::JumpOf(misses, claimed_m);
  if (!jump) return std::nullopt;
  const auto name = [&](std::size_t k) { return positions.photos[in_order[k]]->name; };
  return JumpOfPositions{name(jump->last_before), name(jump->last_before + 1), jump->by_m};
}

std::optional<JumpOfPositions> HeightJumpIn(std::vector<SupportingHeight> heights, double claimed_m) {
  std::stable_sort(heights.begin(), heights.end(), [](const SupportingHeight& a, const SupportingHeight& b) {
    return a.photo->captured_at < b.photo->captured_at;
  });
  std::vector<Vector3d> cameras;
  std::vector<double> misses_m, stated_m;
  for (const SupportingHeight& height : heights) {
    cameras.push_back(height.camera_in_enu);
    misses_m.push_back(height.miss_m);
    stated_m.push_back(height.photo->position->sigma_vertical_m.value_or(0.0));
  }
  const double up_m = std::max(kUpOfSide * claimed_m, MedianIfAny(std::move(stated_m)).value_or(0.0));
  const std::optional<poses::PositionJump> jump = poses::HeightJumpOf(cameras, misses_m, up_m);
  if (!jump) return std::nullopt;
  const auto name = [&](std::size_t k) { return heights[k].photo->name; };
  return JumpOfPositions{name(jump->last_before), name(jump->last_before + 1), jump->by_m};
}

PositionsError ErrorOfLog(const JudgedMap& map) {
  const double noise_m = map.alignment == nullptr ? 0.0 : map.alignment->position_residual_m / std::sqrt(2.0);
  const std::vector<Vector2d> cameras = JudgedCameras(map);
  const auto count = static_cast<double>(std::max<std::size_t>(1, std::min(CountByLog(map), cameras.size())));
  const double sigma_m = map.poses.log_position_sigma_m.value_or(0.0);
  const double shape_m = noise_m * std::sqrt(2.0 / count);
  PositionsError error{std::hypot(sigma_m, shape_m), shape_m, map.poses.log_is_corrected, {}, {}, {}};
  if (OwnErrorM(map) <= 0.0)
    error.lean = OpenLeanOf(map.flight, cameras, map.is_forecast ? sigma_m : noise_m, kAngleOfLogDeg);
  return error;
}

AbsoluteAccuracy ByPositionsAlone(const JudgedMap& map) {
  const double own_m = OwnErrorM(map) / kCircleSigmas;
  const std::size_t placed = JudgedCameras(map).size(), by_log = CountByLog(map);
  const SupportingPositions positions = PositionsOf(map);
  const bool is_by_log = IsPlacedByLog(map, positions);
  // Reckoned from a given place: each photo says how far that may have led it astray.
  if (!is_by_log && positions.records.empty() && by_log > 0)
    return {OfTwoDigits(MedianRadiusM(map)), AbsoluteSupport::kHand, static_cast<int>(by_log)};
  if (!is_by_log && positions.records.empty()) return {};
  const PositionsError error = ErrorOfPositions(map, positions);
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

AbsoluteAccuracy WithContradictions(const JudgedMap& map, AbsoluteAccuracy absolute) {
  if (!IsByReceiver(absolute)) return absolute;
  const SupportingPositions positions = PositionsOf(map);
  double radius_m = std::max(*absolute.sigma_m, MayBeOffM(ContradictionIn(map.flight.warnings)));
  if (AreManyRefuted(positions))
    radius_m = std::hypot(radius_m, kCircleSigmas * SpreadWithRefutedM(map, positions));
  absolute.sigma_m = OfTwoDigits(radius_m);
  return absolute;
}

}  // namespace

bool IsAnyAligned(const JudgedMap& map) {
  return std::any_of(map.flight.photos.begin(), map.flight.photos.end(),
                     [](const AlignedPhoto& photo) { return photo.placement == Placement::kAligned; });
}

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
    positions.photos.push_back(&photo.photo);
    const flight::RecordedPosition& record = *photo.photo.position;
    positions.records.push_back(&record);
    if (!record.is_rtk_fixed || !record.height_ellipsoid_m) continue;
    const Vector3d at = map.flight.frame.EnuFromWgs84(
        {record.position.lat_deg, record.position.lon_deg, *record.height_ellipsoid_m});
    positions.heights.push_back({&photo.photo, camera, at.z() - camera.z()});
  }
  return positions;
}

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

PositionsError ErrorOfPositions(const JudgedMap& map, const SupportingPositions& positions) {
  if (IsPlacedByLog(map, positions)) return ErrorOfLog(map);
  const poses::CommonError common = poses::CommonErrorOf(positions.records);
  const bool is_own = OwnErrorM(map) > 0.0;
  const double noise_m = map.is_forecast || is_own ? 0.0 : NoiseM(positions.misses);
  // What claims to be corrected and scatters by far more is something else, of which nobody knows how much of
  // its error is common to all of them.
  const bool is_false_claim = common.is_corrected && noise_m > poses::kFalseClaim * common.sigma_m;
  const double of_noise_m = is_false_claim ? noise_m : noise_m * std::sqrt(LeverOf(map, positions.places));
  double system_m = 0.0;
  for (const flight::RecordedPosition* record : positions.records)
    system_m = std::max(system_m, record->system_error_m.value_or(0.0));
  PositionsError error{std::hypot(common.sigma_m, of_noise_m, system_m / kCircleSigmas),
                       of_noise_m,
                       common.is_corrected && !is_false_claim,
                       {},
                       {},
                       {}};
  if (!map.is_forecast && !is_own) {
    error.jump = JumpIn(positions, common.sigma_m);
    error.height_jump = HeightJumpIn(positions.heights, common.sigma_m);
  }
  // Either side may be the one that lies off.
  if (error.jump) {
    error.common_m = std::hypot(error.common_m, error.jump->by_m / kCircleSigmas);
    error.shape_m = std::hypot(error.shape_m, error.jump->by_m / kCircleSigmas);
  }
  const double apart_m = map.is_forecast ? common.sigma_m : noise_m;
  if (!is_own) error.lean = OpenLeanOf(map.flight, positions.places, apart_m, kAngleOfNothingDeg);
  return error;
}

AbsoluteAccuracy StatedRadius(double sigma_of_axis_m, AbsoluteSupport by, std::size_t count) {
  return {OfTwoDigits(kCircleSigmas * sigma_of_axis_m), by, static_cast<int>(count)};
}

AbsoluteAccuracy ByPositions(const JudgedMap& map) { return WithContradictions(map, ByPositionsAlone(map)); }

bool IsByReceiver(const AbsoluteAccuracy& absolute) {
  return absolute.sigma_m && (absolute.by == AbsoluteSupport::kGnss || absolute.by == AbsoluteSupport::kRtk);
}

bool AreContradicted(const JudgedMap& map, const AbsoluteAccuracy& absolute) {
  if (!IsByReceiver(absolute)) return false;
  const SupportingPositions positions = PositionsOf(map);
  const PositionsError error = ErrorOfPositions(map, positions);
  return ContradictionIn(map.flight.warnings) != nullptr || AreManyRefuted(positions) || error.jump ||
         error.height_jump;
}

}  // namespace skyquilt::pipeline
