#include "tests/bench/alignment/judge_alignment.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <optional>

#include "core/alignment/align_by_pose.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr double kFalsePairShare = 0.01;  // of a photo's width that a pair's matches may miss by
constexpr double kMaxWorse = 1.1;

using TruePhotos = std::map<std::string, const simulate::SimulatedPhoto*>;

// By how many pixels the second photo shows the place elsewhere than truth says; nothing where truth has
// none.
std::optional<double> ResidualPx(const simulate::SimulatedFlight& truth,
                                 const simulate::SimulatedPhoto& first,
                                 const simulate::SimulatedPhoto& second, const RayPair& shared) {
  constexpr double kFarthestM = 4000.0;
  const camera::Intrinsics& lens = truth.options.intrinsics;
  const geo::Rigid3& first_from_enu = first.pose.cam_from_enu;
  const auto hit = truth.world.CastRay(
      first_from_enu.TargetOriginInSource(),
      (first_from_enu.rotation.conjugate() * lens.Unproject(shared.first)).normalized(), kFarthestM);
  if (!hit) return std::nullopt;
  const auto pixel = lens.Project(second.pose.cam_from_enu * hit->point_in_enu);
  if (!pixel) return std::nullopt;
  return (*pixel - shared.second).norm();
}

// Of a photo taken in motion: every point of it is anywhere along a line of this length.
double StreakPx(const simulate::SimulatedFlight& truth, const simulate::SimulatedPhoto& photo) {
  return photo.render.motion_in_enu_m.norm() / truth.GsdM();
}

void JudgePairs(const AlignedCase& flown, const TruePhotos& by_name, Judgement& judged) {
  const int width_px = flown.truth->options.intrinsics.width_px;
  for (const AlignPairReport& pair : flown.report->pairs) {
    ++judged.pairs;
    if (flown.lies->elsewhere.contains(pair.first) || flown.lies->elsewhere.contains(pair.second)) {
      ++judged.false_pairs;
      continue;
    }
    std::vector<double> misses;
    for (const RayPair& shared : pair.some) {
      const auto miss_px =
          ResidualPx(*flown.truth, *by_name.at(pair.first), *by_name.at(pair.second), shared);
      misses.push_back(miss_px.value_or(width_px));
    }
    const double miss_px = Median(std::move(misses));
    judged.worst_pair_px = std::max(judged.worst_pair_px, miss_px);
    const double streak_px =
        StreakPx(*flown.truth, *by_name.at(pair.first)) + StreakPx(*flown.truth, *by_name.at(pair.second));
    if (miss_px > kFalsePairShare * width_px + 0.5 * streak_px) ++judged.false_pairs;
  }
}

void JudgeLies(const AlignedCase& flown, Judgement& judged) {
  const Lies& lies = *flown.lies;
  for (const AlignPhotoReport& photo : flown.report->photo_reports) {
    const auto has = [&](PhotoFault fault) {
      return std::find(photo.faults.begin(), photo.faults.end(), fault) != photo.faults.end();
    };
    const auto expect = [&](const std::set<std::string>& told, bool is_found, const char* lie) {
      if (!told.contains(photo.name)) return;
      ++judged.lies_told;
      judged.lies_found += is_found ? 1 : 0;
      if (!is_found) judged.faults.push_back(fmt::format("{}: {} not found", photo.name, lie));
    };
    expect(lies.gnss, has(PhotoFault::kPositionWrong), "wrong position");
    expect(lies.yaw, has(PhotoFault::kYawWrong) || has(PhotoFault::kStoredTurned), "wrong yaw");
    expect(lies.elsewhere, has(PhotoFault::kOtherPlace) || has(PhotoFault::kFarAway), "other place");
    expect(lies.duplicate, has(PhotoFault::kCopy), "copy");
    expect(lies.blurred, has(PhotoFault::kBlurred), "blur");
    if (!photo.faults.empty() && !lies.All().contains(photo.name)) {
      judged.faults.push_back(fmt::format("{} is accused: {}", photo.name, FaultName(photo.faults.front())));
    }
  }
}

}  // namespace

Judgement JudgeAlignment(const AlignedCase& flown, const Demands& demands) {
  const simulate::SimulatedFlight& truth = *flown.truth;
  const AlignedFlight& aligned = *flown.aligned;
  const std::set<std::string> liars = flown.lies->All();
  TruePhotos by_name;
  for (const simulate::SimulatedPhoto& photo : truth.photos) by_name[photo.photo.name] = &photo;
  const AlignedFlight by_pose = AlignByPoseOnly(*flown.posed);
  const ground::GroundSurface plane = ground::GroundSurface::Plane(flown.posed->ground_z_in_enu_m);
  Judgement judged;
  judged.error = MeasureGroundError(truth, aligned, *flown.surface, liars);
  judged.pose_error = MeasureGroundError(truth, by_pose, plane, liars);
  judged.gnss = MeasureGnssError(truth, liars);
  const auto miss = [&](std::string words) { judged.faults.push_back(std::move(words)); };

  const double gsd = truth.GsdM();
  if (demands.relative_gsds > 0.0 && judged.error.relative_ce90_m > demands.relative_gsds * gsd) {
    miss(fmt::format("relative error above {} GSD", demands.relative_gsds));
  }
  if (demands.absolute_gsds > 0.0) {
    if (judged.error.absolute_ce90_m > demands.absolute_gsds * gsd) {
      miss(fmt::format("absolute error above {} GSD", demands.absolute_gsds));
    }
  } else if (judged.error.absolute_ce90_m > kMaxWorse * judged.gnss.ce90_m) {
    miss("absolute error above that of the records");
  }
  if (aligned.photos.size() + flown.lies->elsewhere.size() < truth.photos.size())
    miss("a photo is not placed");
  if (demands.improves_every_photo) {
    const std::vector<double> now = RelativePhotoErrorsM(truth, aligned, *flown.surface);
    const std::vector<double> recorded = RelativePhotoErrorsM(truth, by_pose, plane);
    std::map<std::string, double> recorded_m;
    for (std::size_t i = 0; i < recorded.size(); ++i) recorded_m[by_pose.photos[i].photo.name] = recorded[i];
    for (std::size_t i = 0; i < now.size(); ++i) {
      judged.worst_ratio = std::max(judged.worst_ratio, now[i] / recorded_m.at(aligned.photos[i].photo.name));
    }
    if (judged.worst_ratio > kMaxWorse) miss("a photo lies worse than its record");
  }
  JudgePairs(flown, by_name, judged);
  if (demands.has_no_false_pairs && judged.false_pairs > 0) miss("false links survive");
  JudgeLies(flown, judged);
  return judged;
}

}  // namespace skyquilt::alignment
