#include "core/alignment/from_images/georeference.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/alignment/from_images/block.h"
#include "core/base/median.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kPlaneRounds = 12;
constexpr double kSigmaOfGroundRad = 0.1;  // slopes that flights are flown over
constexpr double kSigmaOfAttitudesRad = 0.03;
constexpr double kAgreeRad = 0.09;  // five degrees
constexpr double kAgreeingShare = 0.6;
constexpr std::size_t kFewAttitudes = 3;
constexpr double kAttitudesAgainstGroundRad = 0.27;
constexpr double kMinSpreadSigmas = 6.0;
constexpr int kFewestThatFit = 5;  // of a similarity, which has four degrees of freedom on the ground
constexpr double kTippedSigmas = 4.0;
constexpr double kUnknownHeightM = 1e4;
constexpr double kLooseHeightM = 3.0;
constexpr double kHeightsWorth = 3.0;
constexpr double kPoorestShare = 0.5;  // of the positions' own spread
constexpr double kFarBetterShare = 0.5;
constexpr double kMaxHeightShare = 0.25;

std::vector<std::size_t> PhotosOf(const Registration& registration, int block) {
  std::vector<std::size_t> photos;
  for (std::size_t i = 0; i < registration.Photos(); ++i) {
    if (registration.block_of[i] == block) photos.push_back(i);
  }
  return photos;
}

std::vector<Vector3d> PointsOf(const Registration& registration, int block) {
  std::vector<Vector3d> points;
  for (const Track& track : registration.tracks) {
    const int first = track.observations.front().photo;
    if (registration.block_of[first] == block) points.push_back(track.point_in_enu);
  }
  return points;
}

// The direction most of them share; nothing where fewer than most do.
std::optional<Vector3d> Shared(const std::vector<Vector3d>& directions) {
  if (directions.size() < kFewAttitudes) return std::nullopt;
  Vector3d shared = MedianByAxis(directions).normalized();
  for (int round = 0; round < 2; ++round) {
    Vector3d sum = Vector3d::Zero();
    std::size_t agreeing = 0;
    for (const Vector3d& one : directions) {
      if (std::atan2(one.cross(shared).norm(), one.dot(shared)) > kAgreeRad) continue;
      sum += one;
      ++agreeing;
    }
    if (static_cast<double>(agreeing) < kAgreeingShare * static_cast<double>(directions.size()))
      return std::nullopt;
    shared = sum.normalized();
  }
  return shared;
}

// A direction of enu in the world, as the photos' recorded attitudes have it.
std::optional<Vector3d> ByAttitudes(const Registration& registration, const std::vector<std::size_t>& photos,
                                    const GeoreferenceRecords& records, const Vector3d& in_enu) {
  std::vector<Vector3d> directions;
  for (const std::size_t i : photos) {
    if (!records.photos[i].cam_from_enu) continue;
    directions.push_back(registration.cam_from_world[i].rotation.conjugate() *
                         (*records.photos[i].cam_from_enu * in_enu));
  }
  return Shared(directions);
}

// Up becomes +z; north +y where attitudes tell it, else the top of the first photo's picture.
Quaterniond Orientation(const Registration& registration, const std::vector<std::size_t>& photos,
                        const GeoreferenceRecords& records, const Vector3d& up, bool* knows_north) {
  std::optional<Vector3d> north = ByAttitudes(registration, photos, records, Vector3d::UnitY());
  *knows_north = north.has_value();
  if (!north) north = registration.cam_from_world[photos.front()].rotation.conjugate() * -Vector3d::UnitY();
  Vector3d level = *north - north->dot(up) * up;
  if (level.norm() < 1e-3) level = up.unitOrthogonal();
  level.normalize();
  Eigen::Matrix3d enu_from_world;
  enu_from_world.row(0) = level.cross(up).transpose();
  enu_from_world.row(1) = level.transpose();
  enu_from_world.row(2) = up.transpose();
  return Quaterniond(enu_from_world).normalized();
}

// Positions tell scale and north where they lie further from each other than they err. Much of what they err
// by is common to all (a receiver's, and a clock's along the track): how far apart they err shows where more
// of them than chance would fit to the block do.
bool AreSpread(const std::vector<PlacePair>& pairs, const FittedSimilarity& fitted) {
  std::vector<Vector3d> places;
  for (const PlacePair& pair : pairs) places.push_back(pair.in_target);
  if (places.size() < 3) return false;
  const Vector3d middle = MedianByAxis(places);
  double apart_m = MedianOf(pairs, [](const PlacePair& pair) { return pair.sigma.x(); });
  if (fitted.held >= kFewestThatFit) apart_m = std::min(apart_m, fitted.median_residual);
  const double away_m =
      MedianOf(places, [&](const Vector3d& place) { return (place - middle).head<2>().norm(); });
  return away_m > kMinSpreadSigmas * apart_m;
}

// Whether the positions say that up is the one of two directions rather than the other: where most points are
// on walls the plane through them is no ground.
bool FitFarBetter(const std::vector<PlacePair>& pairs, const UpDirection& one, const UpDirection& other) {
  const std::optional<FittedSimilarity> by_one = FitRobustly(pairs, one, kPoorestShare);
  if (!by_one || !AreSpread(pairs, *by_one)) return false;
  const std::optional<FittedSimilarity> by_other = FitRobustly(pairs, other, kPoorestShare);
  return !by_other || by_one->median_residual < kFarBetterShare * by_other->median_residual;
}

// A level block that surveyed heights tip over: they are wrong, or of points that have none.
bool IsTipped(const FittedSimilarity& fitted, const UpDirection& up) {
  const Vector3d up_in_enu = fitted.target_from_source.rotation * up.in_source.normalized();
  return std::acos(std::clamp(up_in_enu.z(), -1.0, 1.0)) > kTippedSigmas * up.sigma_rad;
}

// The upward normal of the plane through most of the points; nothing of fewer than ten.
std::optional<UpDirection> UpOfGround(const std::vector<Vector3d>& points,
                                      const std::vector<Vector3d>& camera_centers) {
  if (points.size() < 10 || camera_centers.empty()) return std::nullopt;
  std::vector<double> weights(points.size(), 1.0);
  Vector3d normal = Vector3d::UnitZ(), middle = Vector3d::Zero();
  for (int round = 0; round < kPlaneRounds; ++round) {
    double sum = 0.0;
    middle.setZero();
    for (std::size_t k = 0; k < points.size(); ++k) {
      middle += weights[k] * points[k];
      sum += weights[k];
    }
    middle /= sum;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vector3d apart = points[k] - middle;
      scatter += weights[k] * apart * apart.transpose();
    }
    normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    std::vector<double> off;
    for (const Vector3d& point : points) off.push_back(std::abs(normal.dot(point - middle)));
    const double width = std::max(1e-9, 2.0 * Median(off));
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double scaled = off[k] / width;
      weights[k] = 1.0 / ((1.0 + scaled * scaled) * (1.0 + scaled * scaled));
    }
  }
  if (normal.dot(MedianByAxis(camera_centers) - middle) < 0.0) normal = -normal;
  return UpDirection{normal, kSigmaOfGroundRad};
}

// How far above where a block's place puts them its cameras are recorded; nothing without recorded heights.
std::optional<double> RecordedAboveM(const std::vector<std::size_t>& photos,
                                     const std::vector<Vector3d>& centers, const GeoreferenceRecords& records,
                                     const Similarity3& enu_from_world) {
  std::vector<double> above_m;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    const PhotoRecord& record = records.photos[photos[k]];
    if (!record.center_in_enu || !std::isfinite(record.sigma_m.z())) continue;
    above_m.push_back(record.center_in_enu->z() - (enu_from_world * centers[k]).z());
  }
  return MedianIfAny(std::move(above_m));
}

}  // namespace

BlockPlace Georeference(const Registration& registration, int block, const GeoreferenceRecords& records) {
  BlockPlace place;
  place.holding = PhotoSet(registration.Photos());
  const std::vector<std::size_t> photos = PhotosOf(registration, block);
  if (photos.empty()) return place;
  const std::vector<Vector3d> points = PointsOf(registration, block);
  std::vector<Vector3d> centers;
  for (const std::size_t i : photos) centers.push_back(registration.cam_from_world[i].TargetOriginInSource());

  std::vector<PlacePair> pairs;
  std::vector<std::size_t> photo_of;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    const PhotoRecord& record = records.photos[photos[k]];
    if (!record.center_in_enu) continue;
    pairs.push_back({centers[k], *record.center_in_enu, record.sigma_m});
    pairs.back().sigma.z() = std::max(kLooseHeightM, 3.0 * record.sigma_m.z());
    photo_of.push_back(photos[k]);
  }
  // Heights err together, slowly along the flight: however many there are, they are worth a few. More would
  // tilt level ground to a barometer's drift.
  const double worth = std::sqrt(std::max(1.0, static_cast<double>(pairs.size()) / kHeightsWorth));
  for (PlacePair& pair : pairs) pair.sigma.z() *= worth;
  place.positions = static_cast<int>(pairs.size());

  std::optional<UpDirection> up = UpOfGround(points, centers);
  if (const std::optional<Vector3d> told = ByAttitudes(registration, photos, records, Vector3d::UnitZ())) {
    const UpDirection by_attitudes{*told, kSigmaOfAttitudesRad};
    const auto against = [&told](const UpDirection& ground) {
      return std::acos(std::clamp(told->dot(ground.in_source), -1.0, 1.0));
    };
    if (!up || against(*up) < kAttitudesAgainstGroundRad || FitFarBetter(pairs, by_attitudes, *up))
      up = by_attitudes;
  }
  if (!up) {
    // Nothing but that cameras look down.
    Vector3d sum = Vector3d::Zero();
    for (const std::size_t i : photos) {
      sum -= registration.cam_from_world[i].rotation.conjugate() * Vector3d::UnitZ();
    }
    up = UpDirection{sum.norm() > 1e-6 ? Vector3d(sum.normalized()) : Vector3d::UnitZ(), 0.3};
  }
  const auto ground_height = [&](const Similarity3& enu_from_world) {
    if (points.empty()) return 0.0;
    return MedianOf(points, [&](const Vector3d& point) { return (enu_from_world * point).z(); });
  };

  std::vector<PlacePair> control = records.control;
  std::optional<FittedSimilarity> by_control = FitRobustly(control, up);
  const bool has_heights = std::any_of(control.begin(), control.end(),
                                       [](const PlacePair& pair) { return std::isfinite(pair.sigma.z()); });
  if (has_heights && (!by_control || IsTipped(*by_control, *up))) {
    for (PlacePair& pair : control) pair.sigma.z() = kUnknownHeightM;
    by_control = FitRobustly(control, up);
    place.ignores_surveyed_heights = by_control.has_value();
  }
  const auto take = [&](const FittedSimilarity& fitted, Placing placing) {
    place.enu_from_world = fitted.target_from_source;
    place.placing = placing;
    place.median_residual_m = fitted.median_residual;
    place.knows_north = true;
  };
  if (by_control) take(*by_control, Placing::kByControl);
  // Records that are poor everywhere still say better than nothing where and how large the block is.
  const std::optional<FittedSimilarity> by_positions = FitRobustly(pairs, up, kPoorestShare);
  if (by_positions && AreSpread(pairs, *by_positions)) {
    place.spread_sigmas = by_positions->spread_sigmas;
    place.positions_held = by_positions->held;
    for (std::size_t k = 0; k < photo_of.size(); ++k) {
      if (by_positions->holds[k]) place.holding.Add(photo_of[k]);
    }
    if (!by_control) take(*by_positions, Placing::kByPositions);
  }
  // Heights that count from anywhere, or are of another scale than the pictures: the ground lies where the
  // flight's ground lies.
  const auto keep_to_ground = [&](bool trusts_heights) {
    const double ground_z_m = ground_height(place.enu_from_world);
    const double flown_m = MedianOf(
        centers, [&](const Vector3d& center) { return (place.enu_from_world * center).z() - ground_z_m; });
    const double off_m = records.ground_z_in_enu_m - ground_z_m;
    if (!trusts_heights || std::abs(off_m) > kMaxHeightShare * flown_m) {
      place.enu_from_world.shift.z() += off_m;
    }
  };
  if (place.placing == Placing::kByControl) {
    if (place.ignores_surveyed_heights) {
      place.enu_from_world.shift.z() += records.ground_z_in_enu_m - ground_height(place.enu_from_world);
    } else if (records.has_own_zero && has_heights) {
      const std::optional<double> above_m = RecordedAboveM(photos, centers, records, place.enu_from_world);
      place.enu_from_world.shift.z() += above_m.value_or(0.0);
      keep_to_ground(above_m && records.trusts_heights);
    }
    return place;
  }
  if (place.placing == Placing::kByPositions) {
    keep_to_ground(records.trusts_heights);
    return place;
  }

  Similarity3& enu_from_world = place.enu_from_world;
  enu_from_world.rotation = Orientation(registration, photos, records, up->in_source, &place.knows_north);
  std::vector<double> ratios;
  const double ground = ground_height(enu_from_world);
  for (std::size_t k = 0; k < photos.size(); ++k) {
    const std::optional<double>& height = records.photos[photos[k]].height_above_ground_m;
    const double in_world = (enu_from_world * centers[k]).z() - ground;
    if (height && *height > 0.0 && in_world > 0.0) ratios.push_back(*height / in_world);
  }
  if (ratios.size() >= 3) {
    enu_from_world.scale = Median(std::move(ratios));
    place.placing = Placing::kByHeights;
  } else {
    std::vector<double> widths;
    for (std::size_t k = 0; k < photos.size(); ++k) {
      const camera::Intrinsics& lens = registration.LensOf(photos[k]);
      const double in_world = std::max(1e-6, (enu_from_world * centers[k]).z() - ground);
      widths.push_back(in_world / lens.MeanFocalPx() * std::max(lens.width_px, lens.height_px));
    }
    enu_from_world.scale = kGuessedWidthM / Median(std::move(widths));
  }
  // In the middle of what positions there are, otherwise at the frame's origin.
  std::vector<Vector3d> recorded, now;
  for (const PlacePair& pair : pairs) {
    recorded.push_back(pair.in_target);
    now.push_back(enu_from_world * pair.in_source);
  }
  if (pairs.empty()) {
    for (const Vector3d& center : centers) now.push_back(enu_from_world * center);
    recorded.push_back(Vector3d::Zero());
  }
  enu_from_world.shift += MedianByAxis(recorded) - MedianByAxis(now);
  enu_from_world.shift.z() += records.ground_z_in_enu_m - ground_height(enu_from_world);
  return place;
}

}  // namespace skyquilt::alignment
