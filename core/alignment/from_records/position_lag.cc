#include "core/alignment/from_records/position_lag.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/base/check.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kMinPhotosOnLines = 10;
constexpr int kMinLines = 4;
constexpr double kMaxPositionLagS = 30.0;
constexpr double kMinOffSigmas = 0.25;      // of a recorded position: smaller lags change nothing
constexpr double kMaxLeftShare = 0.6;       // of what positions are off by, once the lag is taken out
constexpr double kMinTurnedShare = 0.2;     // of the squared speeds, that the mean course does not explain
constexpr double kSigmaFromMedian = 1.483;  // of the absolute deviation of a normal distribution
constexpr double kHuberSigmas = 1.5;
constexpr int kRounds = 10;

// A photo on a line: how fast it flew, and by how much its record is off from where it lies to the others.
struct Sample {
  Eigen::Vector2d velocity_mps;
  Eigen::Vector2d off_m;
  int line = 0;
};

struct Fit {
  double lag_s = 0.0;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();  // of all positions alike
  Eigen::Vector2d mean_velocity_mps = Eigen::Vector2d::Zero();
  double sum_turned_mps2 = 0.0;  // squared speeds beside the mean course
  double sum_mps2 = 0.0;
};

// off = shift - lag * velocity, by least squares with these weights.
Fit FitOnce(const std::vector<Sample>& samples, const std::vector<double>& weights) {
  double sum = 0.0;
  Eigen::Vector2d mean_velocity = Eigen::Vector2d::Zero(), mean_off = Eigen::Vector2d::Zero();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    sum += weights[k];
    mean_velocity += weights[k] * samples[k].velocity_mps;
    mean_off += weights[k] * samples[k].off_m;
  }
  mean_velocity /= sum;
  mean_off /= sum;
  Fit fit;
  double product = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Eigen::Vector2d turned = samples[k].velocity_mps - mean_velocity;
    product += weights[k] * turned.dot(samples[k].off_m - mean_off);
    fit.sum_turned_mps2 += weights[k] * turned.squaredNorm();
    fit.sum_mps2 += weights[k] * samples[k].velocity_mps.squaredNorm();
  }
  if (fit.sum_turned_mps2 > 0.0) fit.lag_s = -product / fit.sum_turned_mps2;
  fit.shift_m = mean_off + fit.lag_s * mean_velocity;
  fit.mean_velocity_mps = mean_velocity;
  return fit;
}

std::vector<double> LeftBy(const Fit& fit, const std::vector<Sample>& samples) {
  std::vector<double> left_m;
  for (const Sample& sample : samples)
    left_m.push_back((sample.off_m - fit.shift_m + fit.lag_s * sample.velocity_mps).norm());
  return left_m;
}

// A receiver's errors last for minutes: photos of one line are one witness, whatever their number. From how
// far the lines are of different minds (the clustered covariance of Liang and Zeger 1986), with their number
// and the two unknowns taken into account.
struct Certainty {
  int lines = 0;
  double sigma_s = 0.0;

  bool IsEnoughFor(double lag_s) const {
    // Student's distribution at one in a hundred, or stricter.
    return lines >= kMinLines && std::abs(lag_s) > (3.0 + 14.0 / (lines - 2)) * sigma_s;
  }
};

Certainty CertaintyOf(const Fit& fit, const std::vector<Sample>& samples,
                      const std::vector<double>& weights) {
  std::map<int, double> product_of_line;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const Eigen::Vector2d left_m = samples[k].off_m - fit.shift_m + fit.lag_s * samples[k].velocity_mps;
    product_of_line[samples[k].line] +=
        weights[k] * left_m.dot(samples[k].velocity_mps - fit.mean_velocity_mps);
  }
  Certainty certainty;
  certainty.lines = static_cast<int>(product_of_line.size());
  double sum = 0.0;
  for (const auto& [line, product] : product_of_line) sum += product * product;
  const double unknowns = certainty.lines > 2 ? certainty.lines / (certainty.lines - 2.0) : 1.0;
  certainty.sigma_s = std::sqrt(sum * unknowns) / fit.sum_turned_mps2;
  return certainty;
}

// By photo on a line of at least two: from the one before to the one after it on its line.
std::vector<std::optional<Eigen::Vector2d>> Velocities(const std::vector<Eigen::Vector2d>& east_north,
                                                       const std::vector<int>& lines,
                                                       const std::vector<double>& times_s) {
  std::vector<std::optional<Eigen::Vector2d>> velocities(east_north.size());
  for (std::size_t i = 0; i < east_north.size(); ++i) {
    const std::size_t before = i > 0 && lines[i - 1] == lines[i] ? i - 1 : i;
    const std::size_t after = i + 1 < lines.size() && lines[i + 1] == lines[i] ? i + 1 : i;
    const double took_s = times_s[after] - times_s[before];
    if (took_s > 0.0) velocities[i] = (east_north[after] - east_north[before]) / took_s;
  }
  return velocities;
}

}  // namespace

std::optional<PositionLag> FindPositionLag(const BundleProblem& adjusted,
                                           const std::vector<PhotoRecord>& records,
                                           const std::vector<double>& times_s) {
  SKYQUILT_CHECK(records.size() == adjusted.photos.size() && times_s.size() == records.size(),
                 "a record and a time for each photo");
  const PhotoSet tied = ObservingPhotos(records.size(), adjusted.tracks);
  const std::vector<Eigen::Vector2d> east_north = EastNorthOf(adjusted.photos);
  const std::vector<int> lines = FindLines(east_north);
  const std::vector<std::optional<Eigen::Vector2d>> velocities = Velocities(east_north, lines, times_s);
  std::vector<Sample> samples;
  std::vector<double> sigmas_m, speeds_mps;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const BundlePhoto& photo = adjusted.photos[i];
    if (!tied.Has(i) || !velocities[i] || !records[i].center_in_enu || photo.is_fixed) continue;
    const Eigen::Vector2d off_m = (*records[i].center_in_enu + adjusted.clock_error_s * photo.by_clock_mps -
                                   photo.cam_from_enu.TargetOriginInSource())
                                      .head<2>();
    samples.push_back({*velocities[i], off_m, lines[i]});
    sigmas_m.push_back(records[i].sigma_m.head<2>().mean());
    speeds_mps.push_back(velocities[i]->norm());
  }
  if (samples.size() < kMinPhotosOnLines) return std::nullopt;
  std::vector<double> weights(samples.size(), 1.0);
  Fit fit;
  for (int round = 0; round < kRounds; ++round) {
    fit = FitOnce(samples, weights);
    if (!(fit.sum_turned_mps2 > kMinTurnedShare * fit.sum_mps2)) return std::nullopt;
    const std::vector<double> left_m = LeftBy(fit, samples);
    const double spread_m = std::max(1e-6, kSigmaFromMedian * Median(left_m));
    for (std::size_t k = 0; k < samples.size(); ++k)
      weights[k] = std::min(1.0, kHuberSigmas * spread_m / std::max(left_m[k], 1e-9));
  }
  Fit none;
  std::vector<Eigen::Vector2d> offs_m;
  for (const Sample& sample : samples) offs_m.push_back(sample.off_m);
  none.shift_m = MedianByAxis(offs_m);
  PositionLag lag;
  lag.lag_s = fit.lag_s;
  const Certainty certainty = CertaintyOf(fit, samples, weights);
  lag.sigma_s = certainty.sigma_s;
  lag.median_off_m = std::abs(fit.lag_s) * Median(std::move(speeds_mps));
  const bool is_found = certainty.IsEnoughFor(lag.lag_s) && std::abs(lag.lag_s) < kMaxPositionLagS &&
                        lag.median_off_m > kMinOffSigmas * Median(std::move(sigmas_m)) &&
                        Median(LeftBy(fit, samples)) < kMaxLeftShare * Median(LeftBy(none, samples));
  if (!is_found) return std::nullopt;
  for (const std::optional<Eigen::Vector2d>& velocity : velocities) {
    Eigen::Vector3d correction_m = Eigen::Vector3d::Zero();
    if (velocity) correction_m.head<2>() = lag.lag_s * *velocity;
    lag.correction_in_enu.push_back(correction_m);
  }
  return lag;
}

}  // namespace skyquilt::alignment
