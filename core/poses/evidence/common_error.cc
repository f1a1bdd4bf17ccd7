#include "core/poses/evidence/common_error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::poses {
namespace {

constexpr double kCorrectedM = 0.02;
constexpr double kBestPlainM = 0.3;

// `stated_m`: of the positions that state their own accuracy.
CommonError JudgedError(std::size_t positions, std::size_t fixed, std::vector<double> stated_m) {
  const bool most_state = 2 * stated_m.size() > positions;
  const std::optional<double> stated = MedianIfAny(std::move(stated_m));
  CommonError error;
  error.is_corrected = 2 * fixed > positions || (most_state && *stated <= kWorstCorrectedM);
  if (error.is_corrected) {
    error.sigma_m = std::clamp(stated.value_or(kCorrectedM), kCorrectedM, kWorstCorrectedM);
  } else if (most_state) {
    error.sigma_m = std::clamp(*stated, kBestPlainM, kWorstPlainM);
  }
  return error;
}

template <typename Positions, typename Of>
CommonError JudgedErrorOf(const Positions& positions, Of of) {
  std::size_t fixed = 0;
  std::vector<double> stated_m;
  for (const auto& one : positions) {
    const auto& position = of(one);
    fixed += position.is_rtk_fixed ? 1 : 0;
    const std::optional<double>& sigma_m = position.sigma_horizontal_m;
    if (sigma_m && std::isfinite(*sigma_m) && *sigma_m >= flight::kMinStatedM) stated_m.push_back(*sigma_m);
  }
  return JudgedError(positions.size(), fixed, std::move(stated_m));
}

// Lists of positions worked out afterwards have no word for the kind of fix, and state centimetres.
bool StatesCentimetres(const Eigen::Vector3d& sigma_in_ned_m) {
  constexpr double kBestSurveyM = 0.001;  // what says it is better was not measured
  return sigma_in_ned_m.minCoeff() >= kBestSurveyM &&
         sigma_in_ned_m.head<2>().maxCoeff() <= kWorstCorrectedM &&
         sigma_in_ned_m.z() <= 2.0 * kWorstCorrectedM;
}

}  // namespace

bool IsCorrected(const flight::CameraEvent& event) {
  return event.is_rtk_fixed || (event.sigma_in_ned_m && StatesCentimetres(*event.sigma_in_ned_m));
}

double SigmaOfRowM(const flight::CameraEvent& event) {
  if (event.sigma_in_ned_m) {
    const double stated_m = event.sigma_in_ned_m->head<2>().norm() / std::sqrt(2.0);
    if (stated_m >= flight::kMinStatedM) return stated_m;
  }
  return IsCorrected(event) ? kCorrectedM : flight::kPlainSigmaM;
}

CommonError CommonErrorOf(const std::vector<const flight::RecordedPosition*>& positions) {
  return JudgedErrorOf(
      positions, [](const flight::RecordedPosition* one) -> const flight::RecordedPosition& { return *one; });
}

CommonError CommonErrorOf(const std::vector<flight::GnssSample>& samples) {
  return JudgedErrorOf(samples,
                       [](const flight::GnssSample& one) -> const flight::GnssSample& { return one; });
}

}  // namespace skyquilt::poses
