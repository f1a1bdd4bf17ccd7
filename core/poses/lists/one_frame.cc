#include "core/poses/lists/one_frame.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/geo/local_frame.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/own_records.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector2d;
using flight::Photo;
using flight::RecordedPosition;
using flight::RemarkCode;

// Of fewer photos one wrong row is as good as the others.
constexpr std::size_t kFewestPairs = 3;
// Of a shift that all have in common, and what two receivers wander against each other while a flight lasts.
constexpr double kScatterShare = 1.0 / 3.0, kMaxScatterM = 5.0;
// Less between two sources turns no map that anybody could see.
constexpr double kUnseenM = 0.5;
// What a receiver of a phone or a drone is good for: who lies further off contradicts.
constexpr double kReceiverErrsM = 10.0;
// Fewer of the photos do not move a map.
constexpr double kFewShare = 0.1;

// What a list says of a photo less what it says itself.
struct Pair {
  std::size_t photo = 0;
  Vector2d apart_in_en_m = Vector2d::Zero();
  std::optional<double> higher_m;          // above the ellipsoid
  std::optional<double> higher_takeoff_m;  // the same of heights above the take-off
};

struct Camera {
  std::vector<Pair> pairs;
  std::vector<std::size_t> unnamed;  // photos with a position of their own alone
};

struct Shift {
  double typical_m = 0.0;           // median of the lengths
  std::optional<Vector2d> in_en_m;  // nothing: they have none in common
};

bool IsCommon(std::size_t pairs, double shift_m, double scatter_m) {
  return pairs >= kFewestPairs && scatter_m <= std::min(kScatterShare * shift_m, kMaxScatterM);
}

Shift ShiftOf(const std::vector<Pair>& pairs) {
  std::vector<Vector2d> apart;
  std::vector<double> lengths_m, off_m;
  for (const Pair& pair : pairs) {
    apart.push_back(pair.apart_in_en_m);
    lengths_m.push_back(pair.apart_in_en_m.norm());
  }
  const Vector2d median = MedianByAxis(apart);
  for (const Vector2d& one : apart) off_m.push_back((one - median).norm());
  Shift shift;
  shift.typical_m = Median(std::move(lengths_m));
  if (IsCommon(pairs.size(), median.norm(), Median(std::move(off_m)))) shift.in_en_m = median;
  return shift;
}

// Nothing where the heights do not differ, or by no common step.
std::optional<double> CommonStepM(const std::vector<Pair>& pairs, std::optional<double> Pair::*of) {
  std::vector<double> steps_m, off_m;
  for (const Pair& pair : pairs) {
    if (pair.*of) steps_m.push_back(*(pair.*of));
  }
  if (steps_m.empty()) return std::nullopt;
  const double median_m = Median(steps_m);
  for (const double step_m : steps_m) off_m.push_back(std::abs(step_m - median_m));
  const bool is_common = IsCommon(steps_m.size(), std::abs(median_m), Median(std::move(off_m)));
  return is_common && std::abs(median_m) > kUnseenM ? std::optional(median_m) : std::nullopt;
}

std::optional<double> Less(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return *a - *b;
}

Pair PairOf(std::size_t photo, const RecordedPosition& own, const RecordedPosition& of_list) {
  Pair pair;
  pair.photo = photo;
  const geo::LocalFrame here({own.position.lat_deg, own.position.lon_deg, 0.0});
  pair.apart_in_en_m = here.EnuFromWgs84({of_list.position.lat_deg, of_list.position.lon_deg, 0.0}).head<2>();
  pair.higher_m = Less(EllipsoidHeightM(of_list), EllipsoidHeightM(own));
  pair.higher_takeoff_m = Less(of_list.height_above_takeoff_m, own.height_above_takeoff_m);
  return pair;
}

std::map<std::string, Camera> CamerasOf(const std::vector<Photo>& own, const std::vector<Photo>& photos) {
  const OwnRecords records = OwnRecordsOf(own, {});
  std::map<std::string, Camera> cameras;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!records.moving[i] || !photos[i].position) continue;
    Camera& camera = cameras[photos[i].camera_key];
    if (photos[i].position->source == own[i].position->source)
      camera.unnamed.push_back(i);
    else
      camera.pairs.push_back(PairOf(i, *own[i].position, *photos[i].position));
  }
  return cameras;
}

void MoveBy(const Vector2d& shift_in_en_m, RecordedPosition& position) {
  const geo::LocalFrame here({position.position.lat_deg, position.position.lon_deg, 0.0});
  const geo::Wgs84 there = here.Wgs84FromEnu({shift_in_en_m.x(), shift_in_en_m.y(), 0.0});
  position.position = {there.lat_deg, there.lon_deg};
  position.system_error_m.reset();  // the frame that it is in now has its own
}

void Raise(const std::optional<double>& by_m, std::optional<double>& height_m) {
  if (by_m && height_m) *height_m += *by_m;
}

// False: it was held for as bad before.
bool DoubtBy(double apart_m, RecordedPosition& position) {
  const double held_m =
      position.sigma_horizontal_m.value_or(position.is_rtk_fixed ? kWorstCorrectedM : flight::kPlainSigmaM);
  if (apart_m <= held_m) return false;
  position.sigma_horizontal_m = apart_m;
  if (apart_m > kWorstCorrectedM) position.is_rtk_fixed = false;
  return true;
}

// The list, or log, that places most of them.
std::string SourceOf(const std::vector<Pair>& pairs, const std::vector<Photo>& photos) {
  std::map<std::string, std::size_t> count_of;
  for (const Pair& pair : pairs) ++count_of[photos[pair.photo].position->source];
  return std::max_element(count_of.begin(), count_of.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

flight::Remark Said(RemarkCode code, const std::string& file, std::size_t rows, std::size_t others,
                    double apart_m) {
  return {code, {{"file", file}, {"rows", rows}, {"photos", others}, {"apart_m", apart_m}}};
}

void MoveUnnamed(const Camera& camera, const Vector2d& shift_in_en_m, std::vector<Photo>& photos,
                 OneFrame& result) {
  if (shift_in_en_m.norm() <= kUnseenM) return;
  for (const std::size_t i : camera.unnamed) MoveBy(shift_in_en_m, *photos[i].position);
  result.warnings.push_back(Said(RemarkCode::kUnnamedMoved, SourceOf(camera.pairs, photos),
                                 camera.pairs.size(), camera.unnamed.size(), shift_in_en_m.norm()));
}

// Heights may count from another zero where the places agree, and the other way round.
void RaiseUnnamed(const Camera& camera, std::vector<Photo>& photos, OneFrame& result) {
  const std::optional<double> higher_m = CommonStepM(camera.pairs, &Pair::higher_m);
  const std::optional<double> higher_takeoff_m = CommonStepM(camera.pairs, &Pair::higher_takeoff_m);
  for (const std::size_t i : camera.unnamed) {
    RecordedPosition& position = *photos[i].position;
    Raise(higher_m, position.height_ellipsoid_m);
    Raise(higher_m, position.height_amsl_m);
    Raise(higher_takeoff_m, position.height_above_takeoff_m);
  }
  const std::optional<double>& said_m = higher_m ? higher_m : higher_takeoff_m;
  if (!said_m) return;
  result.warnings.push_back(Said(RemarkCode::kUnnamedRaised, SourceOf(camera.pairs, photos),
                                 camera.pairs.size(), camera.unnamed.size(), std::abs(*said_m)));
}

void DoubtUnnamed(const Camera& camera, const std::vector<Pair>& pairs, double apart_m,
                  std::vector<Photo>& photos, OneFrame& result) {
  if (apart_m <= kUnseenM) return;
  std::size_t doubted = 0;
  for (const std::size_t i : camera.unnamed) doubted += DoubtBy(apart_m, *photos[i].position) ? 1U : 0U;
  if (doubted == 0) return;
  result.warnings.push_back(
      Said(RemarkCode::kUnnamedDoubted, SourceOf(pairs, photos), pairs.size(), doubted, apart_m));
  const bool are_few = static_cast<double>(doubted) < kFewShare * static_cast<double>(photos.size());
  if (apart_m > kReceiverErrsM && !are_few)
    result.contradict_m = std::max(result.contradict_m.value_or(0.0), apart_m);
}

}  // namespace

OneFrame BringIntoOneFrame(const std::vector<Photo>& own, std::vector<Photo>& photos) {
  OneFrame result;
  const std::map<std::string, Camera> cameras = CamerasOf(own, photos);
  std::vector<Pair> all;
  for (const auto& [key, camera] : cameras) all.insert(all.end(), camera.pairs.begin(), camera.pairs.end());
  if (all.empty()) return result;
  for (const auto& [key, camera] : cameras) {
    if (camera.unnamed.empty()) continue;
    // Of a camera that no list names it is not known that its receiver errs as another's does, only how much.
    const bool is_named = !camera.pairs.empty();
    const std::vector<Pair>& pairs = is_named ? camera.pairs : all;
    const Shift shift = ShiftOf(pairs);
    if (is_named) RaiseUnnamed(camera, photos, result);
    if (is_named && shift.in_en_m)
      MoveUnnamed(camera, *shift.in_en_m, photos, result);
    else
      DoubtUnnamed(camera, pairs, shift.typical_m, photos, result);
  }
  return result;
}

}  // namespace skyquilt::poses
