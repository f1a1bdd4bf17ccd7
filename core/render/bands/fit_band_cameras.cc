#include "core/render/bands/fit_band_cameras.h"

#include <array>
#include <cmath>
#include <optional>

#include "core/base/median.h"
#include "core/geo/rigid3.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::render {
namespace {

constexpr std::size_t kFewestSightings = 6;
constexpr int kGaussNewtonSteps = 8;
constexpr double kStep = 1e-6;  // of numbers, for slopes
constexpr double kSightingSigmaPx = 0.3, kUsualSightingPx = 0.5;
constexpr double kShiftSigmaM = 0.2;
constexpr double kShiftStiffness = (kSightingSigmaPx / kShiftSigmaM) * (kSightingSigmaPx / kShiftSigmaM);

Eigen::Quaterniond Turned(const Eigen::Vector3d& by_rad, const Eigen::Quaterniond& rotation) {
  return (geo::RotationFromVector(by_rad) * rotation).normalized();
}

std::optional<Eigen::Vector2d> Foretold(const BandLens& lens, const BandStand& stand,
                                        const BandSighting& sighting) {
  const auto pixel =
      lens.intrinsics.Project(stand.band_from_reference * sighting.in_reference_cam + stand.shift_in_band_m);
  if (!pixel) return std::nullopt;
  return Eigen::Vector2d(*pixel + lens.field.At(*pixel));
}

// Without its sightings.
BandStand Stepped(const Eigen::Matrix<double, 5, 1>& by, const BandStand& stand) {
  return {{},
          Turned(by.head<3>(), stand.band_from_reference),
          stand.shift_in_band_m + Eigen::Vector3d(by[3], by[4], 0.0)};
}

double HuberWeight(double miss_px, double scale_px) { return miss_px <= scale_px ? 1.0 : scale_px / miss_px; }

constexpr std::size_t kLensNumbers = 7;
// What is changed of a lens, as shares or as it is: how far off the calibration of a lens may be.
constexpr std::array<double, kLensNumbers> kLensSigmas = {0.01, 0.05, 0.05, 0.003, 0.003, 0.05, 0.002};
camera::Intrinsics Changed(camera::Intrinsics lens, const Eigen::Matrix<double, kLensNumbers, 1>& by) {
  lens.focal_x_px *= 1.0 + by[0];
  lens.focal_y_px *= 1.0 + by[0];
  lens.k1 += by[1];
  lens.k2 += by[2];
  lens.p1 += by[3];
  lens.p2 += by[4];
  lens.k3 += by[5];
  lens.focal_y_px *= 1.0 + by[6];
  return lens;
}

}  // namespace

double MissOf(const BandLens& lens, const BandStand& stand, const BandSighting& sighting) {
  constexpr double kNowhere = 1e9;
  const auto foretold = Foretold(lens, stand, sighting);
  return foretold ? (sighting.pixel_in_band - *foretold).norm() : kNowhere;
}

bool FitStand(const BandLens& lens, double scale_px, BandStand& stand) {
  if (stand.sightings.size() < kFewestSightings) return false;
  // Most must say the same shift before wrong ones can be told from right ones.
  std::vector<double> across, down;
  for (const BandSighting& sighting : stand.sightings) {
    const auto foretold = Foretold(lens, stand, sighting);
    if (!foretold) continue;
    across.push_back(sighting.pixel_in_band.x() - foretold->x());
    down.push_back(sighting.pixel_in_band.y() - foretold->y());
  }
  if (across.size() < kFewestSightings) return false;
  const Eigen::Vector2d shift(Median(std::move(across)), Median(std::move(down)));
  BandStand tried = stand;
  tried.band_from_reference =
      Turned({-shift.y() / lens.intrinsics.focal_y_px, shift.x() / lens.intrinsics.focal_x_px, 0.0},
             stand.band_from_reference);
  for (int round = 0; round < kGaussNewtonSteps; ++round) {
    // Rotation, then the shift across the view; along it nothing moves in a few milliseconds.
    using Numbers = Eigen::Matrix<double, 5, 1>;
    Eigen::Matrix<double, 5, 5> normal = 1e-6 * Eigen::Matrix<double, 5, 5>::Identity();
    Numbers right = Numbers::Zero();
    for (int axis = 0; axis < 2; ++axis) {
      normal(3 + axis, 3 + axis) += kShiftStiffness;
      right[3 + axis] -= kShiftStiffness * tried.shift_in_band_m[axis];
    }
    for (const BandSighting& sighting : tried.sightings) {
      const auto foretold = Foretold(lens, tried, sighting);
      if (!foretold) continue;
      const Eigen::Vector2d miss = sighting.pixel_in_band - *foretold;
      Eigen::Matrix<double, 2, 5> slope;
      bool is_seen = true;
      for (int k = 0; k < 5 && is_seen; ++k) {
        const auto moved = Foretold(lens, Stepped(kStep * Numbers::Unit(k), tried), sighting);
        is_seen = moved.has_value();
        if (is_seen) slope.col(k) = (*moved - *foretold) / kStep;
      }
      if (!is_seen) continue;
      const double weight = HuberWeight(miss.norm(), scale_px);
      normal += weight * slope.transpose() * slope;
      right += weight * slope.transpose() * miss;
    }
    const Numbers step = geo::SolveSymmetric(normal, right);
    if (!step.allFinite()) return false;
    const BandStand stepped = Stepped(step, tried);
    tried.band_from_reference = stepped.band_from_reference;
    tried.shift_in_band_m = stepped.shift_in_band_m;
    if (step.norm() < 1e-8) break;
  }
  std::size_t agreed = 0;
  for (const BandSighting& sighting : tried.sightings)
    agreed += MissOf(lens, tried, sighting) <= 1.5 * scale_px ? 1 : 0;
  if (agreed < kFewestSightings || 3 * agreed < tried.sightings.size()) return false;
  stand.band_from_reference = tried.band_from_reference;
  stand.shift_in_band_m = tried.shift_in_band_m;
  return true;
}

BandLens FitBandLens(const BandLens& lens, const std::vector<BandStand>& stands) {
  using Numbers = Eigen::Matrix<double, kLensNumbers, 1>;
  Numbers by = Numbers::Zero();
  for (int round = 0; round < kGaussNewtonSteps; ++round) {
    Eigen::Matrix<double, kLensNumbers, kLensNumbers> normal;
    normal.setZero();
    Numbers right;
    for (std::size_t k = 0; k < kLensNumbers; ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double stiffness = std::pow(kSightingSigmaPx / kLensSigmas[k], 2);
      normal(at, at) = stiffness;
      right[at] = -stiffness * by[at];
    }
    const BandLens now{Changed(lens.intrinsics, by), lens.field};
    for (const BandStand& stand : stands) {
      // The capture's own numbers are free: what they can take up says nothing of the lens (Schur's
      // complement).
      Eigen::Matrix<double, 5, 5> own = 1e-6 * Eigen::Matrix<double, 5, 5>::Identity();
      Eigen::Matrix<double, kLensNumbers, 5> mixed = Eigen::Matrix<double, kLensNumbers, 5>::Zero();
      Eigen::Matrix<double, 5, 1> own_right = Eigen::Matrix<double, 5, 1>::Zero();
      for (int axis = 3; axis < 5; ++axis) own(axis, axis) += kShiftStiffness;
      for (const BandSighting& sighting : stand.sightings) {
        const auto foretold = Foretold(now, stand, sighting);
        if (!foretold) continue;
        const Eigen::Vector2d miss = sighting.pixel_in_band - *foretold;
        if (miss.norm() > 2.0 * kWrongSightingPx) continue;
        Eigen::Matrix<double, 2, kLensNumbers> slope;
        Eigen::Matrix<double, 2, 5> own_slope;
        bool is_seen = true;
        const auto fill = [&](auto column, const std::optional<Eigen::Vector2d>& moved) {
          is_seen = is_seen && moved.has_value();
          if (moved) column = (*moved - *foretold) / kStep;
        };
        for (int k = 0; k < static_cast<int>(kLensNumbers); ++k)
          fill(slope.col(k), Foretold({Changed(lens.intrinsics, by + kStep * Numbers::Unit(k)), lens.field},
                                      stand, sighting));
        for (int k = 0; k < 5; ++k)
          fill(own_slope.col(k),
               Foretold(now, Stepped(kStep * Eigen::Matrix<double, 5, 1>::Unit(k), stand), sighting));
        if (!is_seen) continue;
        const double weight = HuberWeight(miss.norm(), kUsualSightingPx);
        normal += weight * slope.transpose() * slope;
        right += weight * slope.transpose() * miss;
        own += weight * own_slope.transpose() * own_slope;
        own_right += weight * own_slope.transpose() * miss;
        mixed += weight * slope.transpose() * own_slope;
      }
      normal -= mixed * geo::SolveSymmetric(own, mixed.transpose());
      right -= mixed * geo::SolveSymmetric(own, own_right);
    }
    const Numbers step = geo::SolveSymmetric(normal, right);
    if (!step.allFinite()) break;
    by += step;
    if (step.norm() < 1e-10) break;
  }
  return {Changed(lens.intrinsics, by), lens.field};
}

PixelField FitBandField(const camera::Intrinsics& intrinsics, const std::vector<BandStand>& stands) {
  std::vector<PixelMiss> misses;
  for (const BandStand& stand : stands) {
    for (const BandSighting& sighting : stand.sightings) {
      const auto foretold = Foretold({intrinsics, {}}, stand, sighting);
      if (!foretold) continue;
      const Eigen::Vector2d miss = sighting.pixel_in_band - *foretold;
      if (miss.norm() <= 2.0 * kWrongSightingPx) misses.push_back({*foretold, miss});
    }
  }
  return FitPixelField(intrinsics.width_px, intrinsics.height_px, misses);
}

}  // namespace skyquilt::render
