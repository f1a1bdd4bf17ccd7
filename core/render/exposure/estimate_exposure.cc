#include "core/render/exposure/estimate_exposure.h"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"
#include "core/render/exposure/exposure_samples.h"

namespace skyquilt::render {
namespace {

constexpr int kCurveTerms = 3;
constexpr int kRounds = 5;
// A misfit beyond this (in log value: 12 %) is another thing moving, glint or relief, not exposure.
constexpr double kRobustScale = 0.12;
// How much a photo's gain may stray without evidence, and a curve term. A sample counts little: the misfits
// of one pair of photos go together (the sun's direction, the lens), and many such pairs in a row would add
// up to a drift.
constexpr double kGainSigma = 0.15;
constexpr double kCurveSigma = 0.25;
constexpr double kSampleSigma = 0.35;

// Unknowns: one log gain a photo (one channel), then the curve of each camera. A spot's own brightness is
// eliminated: its samples only speak through their difference from their weighted mean.
struct Unknowns {
  std::size_t photos = 0;
  std::vector<std::size_t> camera_of_photo;
  std::size_t cameras = 0;

  std::size_t count() const { return photos + cameras * kCurveTerms; }
  std::size_t Curve(std::size_t photo, int term) const {
    return photos + camera_of_photo[photo] * kCurveTerms + static_cast<std::size_t>(term);
  }
};

std::array<double, kCurveTerms> Powers(double r2) { return {r2, r2 * r2, r2 * r2 * r2}; }

// log v = spot brightness - log gain + curve(r): the misfit to the spot's mean, given the present unknowns.
double Explained(const ExposureSample& sample, const Unknowns& unknowns, const Eigen::VectorXd& x) {
  double value = -x[static_cast<Eigen::Index>(sample.photo)];
  const auto powers = Powers(sample.radius_squared);
  for (int term = 0; term < kCurveTerms; ++term) {
    value += powers[static_cast<std::size_t>(term)] *
             x[static_cast<Eigen::Index>(unknowns.Curve(sample.photo, term))];
  }
  return value;
}

Eigen::VectorXd SolveChannel(const std::vector<ExposureSample>& samples, int channel,
                             const Unknowns& unknowns) {
  const auto n = static_cast<Eigen::Index>(unknowns.count());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<double> weights(samples.size(), 1.0);
  for (int round = 0; round < kRounds; ++round) {
    std::map<std::pair<Eigen::Index, Eigen::Index>, double> normal;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double sigma = i < static_cast<Eigen::Index>(unknowns.photos) ? kGainSigma : kCurveSigma;
      normal[{i, i}] += kSampleSigma * kSampleSigma / (sigma * sigma);
    }
    for (std::size_t begin = 0; begin < samples.size();) {
      std::size_t end = begin;
      double weight_sum = 0.0;
      double mean = 0.0;
      std::map<Eigen::Index, double> mean_row;
      std::vector<std::map<Eigen::Index, double>> rows;
      for (; end < samples.size() && samples[end].spot == samples[begin].spot; ++end) {
        std::map<Eigen::Index, double> row;
        row[static_cast<Eigen::Index>(samples[end].photo)] = -1.0;
        const auto powers = Powers(samples[end].radius_squared);
        for (int term = 0; term < kCurveTerms; ++term) {
          row[static_cast<Eigen::Index>(unknowns.Curve(samples[end].photo, term))] =
              powers[static_cast<std::size_t>(term)];
        }
        const double w = weights[end];
        weight_sum += w;
        mean += w * samples[end].log_value[static_cast<std::size_t>(channel)];
        for (const auto& [k, a] : row) mean_row[k] += w * a;
        rows.push_back(std::move(row));
      }
      if (weight_sum > 1e-9) {
        // Sum over samples of w a a^T minus the part along the spot's mean.
        for (std::size_t s = begin; s < end; ++s) {
          const auto& row = rows[s - begin];
          const double value = samples[s].log_value[static_cast<std::size_t>(channel)];
          for (const auto& [i, a] : row) {
            right[i] += weights[s] * a * (value - mean / weight_sum);
            for (const auto& [j, b] : row) {
              if (j <= i) normal[{i, j}] += weights[s] * a * b;
            }
          }
        }
        for (const auto& [i, a] : mean_row) {
          for (const auto& [j, b] : mean_row) {
            if (j <= i) normal[{i, j}] -= a * b / weight_sum;
          }
        }
      }
      begin = end;
    }
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(normal.size());
    for (const auto& [at, value] : normal) triplets.emplace_back(at.first, at.second, value);
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    if (solver.info() != Eigen::Success) return x;
    x = solver.solve(right);

    for (std::size_t begin = 0; begin < samples.size();) {
      std::size_t end = begin;
      std::vector<double> left;
      for (; end < samples.size() && samples[end].spot == samples[begin].spot; ++end) {
        left.push_back(samples[end].log_value[static_cast<std::size_t>(channel)] -
                       Explained(samples[end], unknowns, x));
      }
      const double centre = left.size() == 2 ? 0.5 * (left[0] + left[1]) : Median(left);
      for (std::size_t s = begin; s < end; ++s) {
        const double misfit = (left[s - begin] - centre) / kRobustScale;
        weights[s] = 1.0 / (1.0 + misfit * misfit);  // Cauchy
      }
      begin = end;
    }
  }
  return x;
}

// The polynomial whose value is nearest to exp(curve) over the image: what the renderer divides by.
Vignetting VignettingFromLogCurve(const std::array<double, kCurveTerms>& log_curve) {
  constexpr int kPoints = 33;
  Eigen::Matrix<double, kPoints, kCurveTerms> basis;
  Eigen::Matrix<double, kPoints, 1> target;
  for (int i = 0; i < kPoints; ++i) {
    const auto powers = Powers(static_cast<double>(i) / (kPoints - 1));
    double value = 0.0;
    for (int term = 0; term < kCurveTerms; ++term) {
      basis(i, term) = powers[static_cast<std::size_t>(term)];
      value += powers[static_cast<std::size_t>(term)] * log_curve[static_cast<std::size_t>(term)];
    }
    target(i) = std::exp(std::clamp(value, -1.2, 0.5)) - 1.0;
  }
  const Eigen::Matrix<double, kCurveTerms, 1> fitted = basis.colPivHouseholderQr().solve(target);
  Vignetting vignetting;
  for (int term = 0; term < kCurveTerms; ++term) vignetting.a[static_cast<std::size_t>(term)] = fitted(term);
  return vignetting;
}

}  // namespace

ExposureModel EstimateExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                               const std::vector<Thumbnail>& thumbnails) {
  ExposureModel model{std::vector<PhotoTone>(flight.photos.size())};
  const std::vector<ExposureSample> samples = SampleExposure(flight, ground, thumbnails);
  if (samples.empty()) return model;
  Unknowns unknowns;
  unknowns.photos = flight.photos.size();
  std::map<std::string, std::size_t> cameras;
  for (const auto& photo : flight.photos) {
    unknowns.camera_of_photo.push_back(
        cameras.try_emplace(photo.photo.camera_key, cameras.size()).first->second);
  }
  unknowns.cameras = cameras.size();

  std::vector<std::array<double, kCurveTerms>> curves(unknowns.cameras);
  for (int channel = 0; channel < 3; ++channel) {
    const Eigen::VectorXd x = SolveChannel(samples, channel, unknowns);
    double mean = 0.0;
    for (std::size_t i = 0; i < unknowns.photos; ++i) mean += x[static_cast<Eigen::Index>(i)];
    mean /= static_cast<double>(unknowns.photos);
    for (std::size_t i = 0; i < unknowns.photos; ++i) {
      model.photos[i].gain[static_cast<std::size_t>(channel)] =
          std::exp(std::clamp(x[static_cast<Eigen::Index>(i)] - mean, -1.2, 1.2));
    }
    for (std::size_t camera = 0; camera < unknowns.cameras; ++camera) {
      for (int term = 0; term < kCurveTerms; ++term) {
        curves[camera][static_cast<std::size_t>(term)] +=
            x[static_cast<Eigen::Index>(unknowns.photos + camera * kCurveTerms +
                                        static_cast<std::size_t>(term))] /
            3.0;
      }
    }
  }
  for (std::size_t i = 0; i < unknowns.photos; ++i) {
    model.photos[i].vignetting = VignettingFromLogCurve(curves[unknowns.camera_of_photo[i]]);
  }
  return model;
}

}  // namespace skyquilt::render
