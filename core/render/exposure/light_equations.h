// LightEquations: the robust least-squares problem behind EstimateExposure, for one channel: what each
// photo's gain, each camera's terms and the terms of direction are, so that photos agree about spots of
// ground that several show. A spot's own brightness is eliminated: its samples speak through their
// differences alone, so that whatever the ground really looks like stays. Method: normal equations with the
// few terms of the flight eliminated last (Schur complement), reweighted by a Cauchy loss. One thread;
// O(samples x terms^2).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "core/render/exposure/exposure.h"
#include "core/render/exposure/exposure_samples.h"

namespace skyquilt::render {

// Which terms there are.
struct LightTerms {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> camera_of_photo;  // in `cameras`; kNone: of too few photos for terms of its own
  std::vector<std::string> cameras;          // their keys
  std::vector<double> exposure_of_photo;     // the recorded one as a logarithm, less its camera's usual one
  Directions directions;

  std::size_t photos() const { return camera_of_photo.size(); }
  static constexpr std::size_t kExposure = kDirectionTerms;  // how much of a recorded exposure photos show
  static constexpr std::size_t kOfFlight = kExposure + 1;
  std::size_t count() const { return kOfFlight + kCameraTerms * cameras.size(); }
  static std::size_t OfCamera(std::size_t camera) { return kOfFlight + kCameraTerms * camera; }
};

struct SolvedLight {
  Eigen::VectorXd log_gains;  // by photo
  Eigen::VectorXd terms;      // of direction, of exposure, then of each camera
  // By hill of the hot spot: what all of these become more where that hill is one higher, the other hills
  // stay and the rest fits the samples as well as it can. Empty without a hot spot.
  Eigen::MatrixXd gains_by_hill, terms_by_hill;
};

// How much a sample counts with such a misfit.
double SampleWeight(double misfit);

// What gains and terms make of a sample's ground, as a logarithm.
double Explained(const ExposureSample& sample, const LightTerms& terms, const Eigen::VectorXd& log_gains,
                 const Eigen::VectorXd& of_terms);

// What the solved terms leave of each sample, less the middle of its spot's; 0 where photos agree.
std::vector<double> MisfitsOf(const std::vector<ExposureSample>& samples, std::size_t channel,
                              const LightTerms& terms, const SolvedLight& light);

// Samples as SampleExposure has them. All zero where the equations have no solution.
SolvedLight SolveLight(const std::vector<ExposureSample>& samples, std::size_t channel,
                       const LightTerms& terms);

}  // namespace skyquilt::render
