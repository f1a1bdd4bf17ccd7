#include "core/alignment/from_records/gyro_lag.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/alignment/bundle/readout_motion.h"
#include "core/alignment/estimators/epipolar.h"
#include "core/alignment/matching/match_descriptors.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"

namespace skyquilt::alignment {
namespace {

constexpr double kMaxLagS = 0.08;
constexpr double kCoarseStepS = 0.008, kFineStepS = 0.001;
constexpr std::size_t kMaxComparedPairs = 48, kMaxUsedPairs = 24;
constexpr std::size_t kNeighbours = 3;  // of each photo, nearest by position
constexpr std::size_t kMinMatches = 30;
constexpr double kMotionToleranceShare = 0.0012;  // of a photo's width
constexpr int kMinFitting = 40;
constexpr double kBetterShare = 1.08;  // by so much more must fit, or the lag is not believed
constexpr double kWorseShare = 0.97;   // with so many fewer fitting, the record is not
constexpr double kNearBestShare = 0.97;
// How thoroughly a pair is looked at. Most lags fit hardly anything, which takes the longest to find out.
struct Effort {
  std::size_t max_matches = 0;
  int max_trials = 0;
};
constexpr Effort kCoarse{100, 100}, kFine{400, 1000};

// With a gyro whose lag is to be found.
bool IsOpen(const poses::PosedPhoto& posed) {
  const flight::Photo& photo = posed.photo;
  return photo.turning && photo.readout_s && !photo.is_resaved_by_viewer && !posed.readout_motion;
}

// Photos of one camera with a gyro that lie nearest to each other, spread over the flight.
std::vector<PhotoPair> NearestPairs(const poses::PosedFlight& posed, const std::vector<std::size_t>& photos) {
  std::vector<std::pair<int, int>> near;
  for (const std::size_t i : photos) {
    const Eigen::Vector3d place = posed.photos[i].cam_from_enu.TargetOriginInSource();
    std::vector<std::pair<double, std::size_t>> others;
    for (const std::size_t j : photos) {
      if (j != i)
        others.emplace_back((posed.photos[j].cam_from_enu.TargetOriginInSource() - place).norm(), j);
    }
    for (const std::size_t j : LeastFew(std::move(others), kNeighbours)) near.emplace_back(std::minmax(i, j));
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<PhotoPair> pairs;
  const std::size_t count = std::min(kMaxComparedPairs, near.size());
  for (std::size_t k = 0; k < count; ++k) {
    const auto& [first, second] = near[k * near.size() / count];
    pairs.push_back({first, second, {}, {}});
  }
  return pairs;
}

// Where the middle row would have looked to see what a keypoint shows, at focal length one.
Eigen::Vector2d InMiddle(const camera::Intrinsics& lens, const camera::RowMotion& motion,
                         const Keypoint& keypoint) {
  const double share = camera::RowShare(keypoint.y_px, lens.height_px);
  return (motion.TurnAt(share).conjugate() * lens.Unproject({keypoint.x_px, keypoint.y_px})).hnormalized();
}

// Without a lag: no turns at all. A finished photo's are known for good.
camera::RowMotion TurnsWithLag(const poses::PosedPhoto& posed, std::optional<double> lag_s) {
  if (!lag_s) return {};
  if (posed.readout_motion) return *posed.readout_motion;
  const flight::Photo& photo = posed.photo;
  flight::RecordedTurning turning = *photo.turning;
  for (flight::TurnRate& sample : turning.samples) sample.time_s -= *lag_s;
  return {Eigen::Vector3d::Zero(),
          TurnsOfRows(turning, *photo.readout_s, photo.exposure_time_s.value_or(0.0))};
}

int Fitting(const poses::PosedFlight& posed, const std::vector<const PhotoFeatures*>& features,
            const PhotoPair& pair, std::optional<double> lag_s, const Effort& effort) {
  const flight::Photo& first = posed.photos[pair.first].photo;
  const flight::Photo& second = posed.photos[pair.second].photo;
  const camera::RowMotion of_first = TurnsWithLag(posed.photos[pair.first], lag_s);
  const camera::RowMotion of_second = TurnsWithLag(posed.photos[pair.second], lag_s);
  std::vector<RayPair> places;
  const std::size_t step = (pair.matches.size() + effort.max_matches - 1) / effort.max_matches;
  for (std::size_t k = 0; k < pair.matches.size(); k += step) {
    const Keypoint& from = features[pair.first]->keypoints[pair.matches[k].first];
    const Keypoint& to = features[pair.second]->keypoints[pair.matches[k].second];
    places.push_back(
        {InMiddle(first.intrinsics, of_first, from), InMiddle(second.intrinsics, of_second, to)});
  }
  const double tolerance = kMotionToleranceShare * first.intrinsics.width_px / first.intrinsics.MeanFocalPx();
  const std::optional<RobustFit> fit = RobustHomography(places, tolerance, effort.max_trials);
  return fit ? static_cast<int>(fit->inliers.size()) : 0;
}

// Summed over all pairs.
std::vector<int> FittingAt(const poses::PosedFlight& posed, const std::vector<const PhotoFeatures*>& features,
                           const std::vector<PhotoPair>& pairs,
                           const std::vector<std::optional<double>>& lags_s, const Effort& effort,
                           int threads) {
  std::vector<int> of_each(pairs.size() * lags_s.size());
  ParallelFor(of_each.size(), threads, [&](std::size_t k) {
    of_each[k] = Fitting(posed, features, pairs[k / lags_s.size()], lags_s[k % lags_s.size()], effort);
  });
  std::vector<int> sums(lags_s.size(), 0);
  for (std::size_t k = 0; k < of_each.size(); ++k) sums[k % lags_s.size()] += of_each[k];
  return sums;
}

std::vector<std::optional<double>> LagsAround(double middle_s, double reach_s, double step_s) {
  std::vector<std::optional<double>> lags_s;
  const int steps = static_cast<int>(std::lround(reach_s / step_s));
  for (int k = -steps; k <= steps; ++k) lags_s.emplace_back(middle_s + k * step_s);
  return lags_s;
}

void FindLag(const poses::PosedFlight& posed, const std::vector<const PhotoFeatures*>& features,
             const std::vector<PhotoPair>& pairs, int threads, GyroReport& report) {
  std::vector<std::optional<double>> lags_s = LagsAround(0.0, kMaxLagS, kCoarseStepS);
  std::vector<int> fitting = FittingAt(posed, features, pairs, lags_s, kCoarse, threads);
  const auto best = std::max_element(fitting.begin(), fitting.end());
  const double coarse_s = **(lags_s.begin() + (best - fitting.begin()));
  lags_s = LagsAround(coarse_s, kCoarseStepS, kFineStepS);
  lags_s.emplace_back();
  fitting = FittingAt(posed, features, pairs, lags_s, kFine, threads);
  report.fitting_without = fitting.back();
  fitting.pop_back();
  // The middle of the peak: single counts waver.
  report.fitting = *std::max_element(fitting.begin(), fitting.end());
  if (report.fitting == 0) return;
  double sum_s = 0.0, weights = 0.0;
  for (std::size_t k = 0; k < fitting.size(); ++k) {
    const double over = fitting[k] - kNearBestShare * report.fitting;
    if (over <= 0.0) continue;
    sum_s += over * *lags_s[k];
    weights += over;
  }
  report.lag_s = sum_s / weights;
}

}  // namespace

std::vector<GyroReport> TieGyrosToRows(poses::PosedFlight& posed,
                                       const std::vector<const PhotoFeatures*>& features, int threads) {
  std::map<std::string, std::vector<std::size_t>> of_camera;
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    if (IsOpen(posed.photos[i])) of_camera[posed.photos[i].photo.camera_key].push_back(i);
  }
  std::vector<GyroReport> reports;
  for (const auto& [camera_key, photos] : of_camera) {
    GyroReport report;
    report.camera_key = camera_key;
    std::vector<std::size_t> readable;
    for (const std::size_t i : photos)
      if (features[i] != nullptr) readable.push_back(i);
    // Of a camera of which a part is finished, that part tells most.
    for (std::size_t i = 0; i < posed.photos.size(); ++i) {
      const poses::PosedPhoto& other = posed.photos[i];
      if (features[i] != nullptr && other.readout_motion && !other.readout_motion->turns_rad.empty() &&
          other.photo.camera_key == camera_key) {
        readable.push_back(i);
      }
    }
    std::vector<PhotoPair> pairs = NearestPairs(posed, readable);
    std::erase_if(pairs, [&](const PhotoPair& pair) {
      return !IsOpen(posed.photos[pair.first]) && !IsOpen(posed.photos[pair.second]);
    });
    ParallelFor(pairs.size(), threads, [&](std::size_t k) {
      pairs[k].matches = MatchDescriptors(*features[pairs[k].first], *features[pairs[k].second]);
    });
    std::erase_if(pairs, [](const PhotoPair& pair) { return pair.matches.size() < kMinMatches; });
    std::stable_sort(pairs.begin(), pairs.end(), [](const PhotoPair& a, const PhotoPair& b) {
      return a.matches.size() > b.matches.size();
    });
    if (pairs.size() > kMaxUsedPairs) pairs.resize(kMaxUsedPairs);
    report.pairs = static_cast<int>(pairs.size());
    for (const PhotoPair& pair : pairs) report.matches += static_cast<int>(pair.matches.size());
    if (!pairs.empty()) FindLag(posed, features, pairs, threads, report);
    const bool is_found =
        report.fitting >= kMinFitting && report.fitting > kBetterShare * report.fitting_without;
    if (!is_found) report.lag_s = 0.0;
    report.is_used = report.fitting >= kWorseShare * report.fitting_without;
    for (const std::size_t i : photos) {
      std::optional<flight::RecordedTurning>& turning = posed.photos[i].photo.turning;
      if (!report.is_used) {
        turning.reset();
        continue;
      }
      for (flight::TurnRate& sample : turning->samples) sample.time_s -= report.lag_s;
    }
    reports.push_back(report);
  }
  return reports;
}

}  // namespace skyquilt::alignment
