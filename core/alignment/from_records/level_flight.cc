#include "core/alignment/from_records/level_flight.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kMinPhotos = 6;
constexpr double kMaxSigmaTiltRad = 0.02;  // a gimbal's, or better
constexpr double kMinTiltSigmas = 2.5;     // of one photo's angles: what all of a flight's can share
constexpr double kMaxSpreadShare = 0.4;    // of the tilt: how far half of the photos may be of another mind
constexpr double kMinSigmaHeightM = 0.3;   // better heights outweigh any gimbal
constexpr std::ptrdiff_t kSharingPhotos = 3;  // before and after, that share the error of a height
constexpr double kSameVerticalRad = 1e-4;

// The turn of `enu` that brings a photo from where it was adjusted to its recorded angles, without the turn
// about the vertical, which positions hold.
Eigen::Vector2d TiltOf(const geo::Rigid3& adjusted, const Eigen::Quaterniond& recorded_cam_from_enu) {
  const Eigen::Vector3d turn =
      geo::VectorFromRotation((recorded_cam_from_enu.conjugate() * adjusted.rotation).normalized());
  return turn.head<2>();
}

Eigen::Vector3d Turned(const Levelling& levelling, const Eigen::Vector3d& at) {
  return levelling.pivot_in_enu + levelling.level_from_tilted * (at - levelling.pivot_in_enu);
}

geo::Rigid3 Turned(const Levelling& levelling, const geo::Rigid3& cam_from_enu) {
  return geo::Rigid3::FromRotationAndTargetOrigin(
      (cam_from_enu.rotation * levelling.level_from_tilted.conjugate()).normalized(),
      Turned(levelling, cam_from_enu.TargetOriginInSource()));
}

bool HasSameVertical(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return ((a * Eigen::Vector3d::UnitZ()) - (b * Eigen::Vector3d::UnitZ())).norm() < kSameVerticalRad;
}

// Each value as it and its neighbours in time have it: keeps steps, drops single errors.
std::vector<double> RunningMedian(const std::vector<double>& values) {
  std::vector<double> smooth;
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const auto from = values.begin() + std::max<std::ptrdiff_t>(0, i - kSharingPhotos);
    const auto to = values.begin() + std::min(count, i + kSharingPhotos + 1);
    smooth.push_back(Median(std::vector<double>(from, to)));
  }
  return smooth;
}

}  // namespace

std::optional<Levelling> FindLevelling(const BundleProblem& adjusted,
                                       const std::vector<PhotoRecord>& records) {
  const PhotoSet tied = ObservingPhotos(adjusted.photos.size(), adjusted.tracks);
  std::vector<std::size_t> placed;  // photos that say where and which way up
  std::vector<Eigen::Vector2d> tilts;
  std::vector<double> sigmas_tilt, sigmas_height;
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const PhotoRecord& record = records[i];
    if (!tied.Has(i) || !record.center_in_enu || !std::isfinite(record.sigma_m.z()) ||
        adjusted.photos[i].is_fixed)
      continue;
    sigmas_height.push_back(record.sigma_m.z());
    pivot += adjusted.photos[i].cam_from_enu.TargetOriginInSource();
    placed.push_back(i);
    if (!record.cam_from_enu || record.sigma_tilt_rad > kMaxSigmaTiltRad) continue;
    sigmas_tilt.push_back(record.sigma_tilt_rad);
    tilts.push_back(TiltOf(adjusted.photos[i].cam_from_enu, *record.cam_from_enu));
  }
  if (tilts.size() < kMinPhotos || 2 * tilts.size() < placed.size()) return std::nullopt;
  if (Median(std::move(sigmas_height)) < kMinSigmaHeightM) return std::nullopt;
  const Eigen::Vector2d tilt = MedianByAxis(tilts);
  if (tilt.norm() < kMinTiltSigmas * Median(std::move(sigmas_tilt))) return std::nullopt;
  const double apart = MedianOf(tilts, [&](const Eigen::Vector2d& one) { return (one - tilt).norm(); });
  if (apart > kMaxSpreadShare * tilt.norm()) return std::nullopt;

  Levelling levelling;
  levelling.level_from_tilted = geo::RotationFromVector({tilt.x(), tilt.y(), 0.0});
  levelling.pivot_in_enu = pivot / static_cast<double>(placed.size());
  levelling.tilt_rad = tilt.norm();
  std::vector<double> off;
  for (const std::size_t i : placed) {
    const Eigen::Vector3d center = adjusted.photos[i].cam_from_enu.TargetOriginInSource();
    off.push_back(Turned(levelling, center).z() - records[i].center_in_enu->z());
  }
  off = RunningMedian(off);
  levelling.height_correction_m.assign(records.size(), 0.0);
  for (std::size_t k = 0; k < placed.size(); ++k) levelling.height_correction_m[placed[k]] = off[k];
  const auto [lowest, highest] = std::minmax_element(off.begin(), off.end());
  levelling.height_range_m = *highest - *lowest;
  return levelling;
}

void Level(const Levelling& levelling, const std::vector<PhotoRecord>& records, BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.photos.size(); ++i) {
    BundlePhoto& photo = problem.photos[i];
    photo.cam_from_enu = Turned(levelling, photo.cam_from_enu);
    const geo::Rigid3 prior = photo.prior_cam_from_enu;
    const geo::Rigid3 turned = Turned(levelling, prior);
    const bool is_recorded_attitude =
        !photo.is_by_images ||
        (records[i].cam_from_enu && HasSameVertical(prior.rotation, *records[i].cam_from_enu));
    const Eigen::Vector3d recorded =
        prior.TargetOriginInSource() + Eigen::Vector3d(0.0, 0.0, levelling.height_correction_m[i]);
    photo.prior_cam_from_enu =
        geo::Rigid3::FromRotationAndTargetOrigin(is_recorded_attitude ? prior.rotation : turned.rotation,
                                                 photo.has_record ? recorded : turned.TargetOriginInSource());
  }
  for (auto* tracks : {&problem.tracks, &problem.soft_tracks}) {
    for (Track& track : *tracks) track.point_in_enu = Turned(levelling, track.point_in_enu);
  }
  problem.plane.reset();
}

}  // namespace skyquilt::alignment
