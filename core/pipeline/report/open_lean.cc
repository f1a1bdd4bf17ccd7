#include "core/pipeline/report/open_lean.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::pipeline {
namespace {

// As they are placed by (core/poses/place_by_records.cc).
double SharedAngleDeg(const flight::Photo& photo, double unsaid_deg) {
  constexpr double kOfGimbalDeg = 1.0, kOfBodyDeg = 2.0;
  if (!photo.attitude) return unsaid_deg;
  return photo.attitude->kind == flight::AttitudeKind::kGimbal ? kOfGimbalDeg : kOfBodyDeg;
}

// Of heights within one flight: adjustment believes barometers this far, receivers by how they scatter.
double HeightNoiseM(double noise_m) {
  constexpr double kBestM = 0.002, kBarometerM = 0.1;
  return std::clamp(noise_m, kBestM, kBarometerM);
}

}  // namespace

OpenLean OpenLeanOf(const alignment::AlignedFlight& flight, const std::vector<Eigen::Vector2d>& places,
                    double noise_m, double unsaid_deg) {
  if (places.empty()) return {};
  std::vector<double> angles_deg, heights_m;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    angles_deg.push_back(SharedAngleDeg(photo.photo, unsaid_deg));
    heights_m.push_back(photo.height_above_ground_m);
  }
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& place : places) middle += place / static_cast<double>(places.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& place : places)
    spread += (place - middle) * (place - middle).transpose() / static_cast<double>(places.size());
  OpenLean lean;
  lean.sigma_rad = geo::DegToRad(MedianIfAny(std::move(angles_deg)).value_or(0.0));
  const double height_m = MedianIfAny(std::move(heights_m)).value_or(0.0);
  // Along the positions' longest axis and across it: heights hold a turn by how far out they lie. Photo for
  // photo, as angles are weighed against heights, so that many photos of one line hold it no better.
  const double mean_m2 = 0.5 * spread.trace();
  const double apart_m2 = std::hypot(0.5 * (spread(0, 0) - spread(1, 1)), spread(0, 1));
  double square_m2 = 0.0;
  for (const double away_m2 : {mean_m2 + apart_m2, std::max(0.0, mean_m2 - apart_m2)}) {
    const double held = away_m2 * std::pow(lean.sigma_rad / HeightNoiseM(noise_m), 2);
    square_m2 += 0.5 * std::pow(height_m * lean.sigma_rad / (1.0 + held), 2);
  }
  lean.off_m = std::sqrt(square_m2);
  return lean;
}

}  // namespace skyquilt::pipeline
