#include "core/poses/lists/list_rounding.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "core/geo/geodesic.h"
#include "core/geo/lat_lon.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {
namespace {

// As many numbers end in 0 by chance in one list of a million.
constexpr std::size_t kFewestNumbers = 6;

// The coarsest first.
std::vector<double> StepsTried(bool are_degrees) {
  constexpr int kPlacesTried = 6;
  constexpr double kMinutesADegree = 60.0, kSecondsADegree = 3600.0, kLongestStepM = 1000.0;
  std::vector<double> steps;
  double decimal = 1.0;
  for (int places = 0; places < kPlacesTried; ++places, decimal *= 10.0) {
    if (are_degrees) {
      for (const double parts : {1.0, kMinutesADegree, kSecondsADegree})
        steps.push_back(1.0 / (parts * decimal));
    } else {
      steps.push_back(kLongestStepM / decimal);
    }
  }
  std::sort(steps.begin(), steps.end(), std::greater<>());
  return steps;
}

bool IsWholeIn(double step, double number) {
  constexpr double kOfReading = 1e-6;  // what is lost where text becomes a number
  const double steps = number / step;
  return std::abs(steps - std::round(steps)) <= kOfReading;
}

bool AreManyNumbers(const std::vector<flight::WrittenPlace>& rows) {
  std::set<double> east, north;
  for (const flight::WrittenPlace& row : rows) {
    east.insert(row.x);
    north.insert(row.y);
  }
  return east.size() + north.size() >= kFewestNumbers;
}

}  // namespace

std::optional<double> FindWrittenStep(const std::vector<flight::WrittenPlace>& rows, bool are_degrees) {
  for (const double step : StepsTried(are_degrees)) {
    const bool are_whole = std::all_of(rows.begin(), rows.end(), [&](const flight::WrittenPlace& row) {
      return IsWholeIn(step, row.x) && IsWholeIn(step, row.y);
    });
    if (are_whole) return AreManyNumbers(rows) ? std::optional(step) : std::nullopt;
  }
  return std::nullopt;
}

double SigmaOfStep(double step) { return step / std::sqrt(12.0); }

bool WidenToStep(double step_m, flight::CameraEvent& event) {
  const double sigma_m = SigmaOfStep(step_m);
  if (SigmaOfRowM(event) >= sigma_m) return false;
  constexpr double kUnsaidVerticalM = 2.0 * flight::kPlainSigmaM;
  const double vertical_m = event.sigma_in_ned_m ? event.sigma_in_ned_m->z() : kUnsaidVerticalM;
  event.sigma_in_ned_m = Eigen::Vector3d(sigma_m, sigma_m, vertical_m);
  event.is_rtk_fixed = false;
  return true;
}

std::optional<double> WidenToStep(std::vector<flight::GnssSample>& fixes) {
  std::vector<flight::WrittenPlace> rows;
  rows.reserve(fixes.size());
  for (const flight::GnssSample& fix : fixes) rows.push_back({fix.position.lon_deg, fix.position.lat_deg});
  const std::optional<double> step_deg = FindWrittenStep(rows, true);
  if (!step_deg) return std::nullopt;
  const geo::LatLon& first = fixes.front().position;
  const double to_equator_deg = first.lat_deg > 0.0 ? -*step_deg : *step_deg;
  const double step_m = geo::MetresApart(first, {first.lat_deg + to_equator_deg, first.lon_deg});
  const double sigma_m = SigmaOfStep(step_m);
  bool any = false;
  for (flight::GnssSample& fix : fixes) {
    const double assumed_m = fix.is_rtk_fixed ? flight::kFixedSigmaM : flight::kPlainSigmaM;
    if (sigma_m <= kWorstCorrectedM || fix.sigma_horizontal_m.value_or(assumed_m) >= sigma_m) continue;
    fix.sigma_horizontal_m = sigma_m;
    fix.is_rtk_fixed = false;
    any = true;
  }
  return any ? std::optional(step_m) : std::nullopt;
}

}  // namespace skyquilt::poses
