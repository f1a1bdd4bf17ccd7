// Tracks: one point on the ground and the keypoints of several photos that see it. Built from pairwise
// matches, contradictory ones taken apart, thinned so that every photo keeps a few hundred, spread over its
// picture. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct Observation {
  int photo = 0;
  Eigen::Vector2d pixel_in_image = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;
};

struct Track {
  std::vector<Observation> observations;
  Eigen::Vector3d point_in_enu = Eigen::Vector3d::Zero();
  double angle_rad = 0.0;  // the widest angle between two of its rays
};

// Which of so many photos see any of the tracks.
PhotoSet ObservingPhotos(std::size_t photos, const std::vector<Track>& tracks);

// Photos that see fewer are not held by them.
inline constexpr int kEnoughObservations = 12;

struct TrackOptions {
  int observations_per_photo = 220;
  int cells_across = 14;
  // Chains of matches that lead to two places of one photo are of no use as they are; true: each of their
  // matches becomes a track of its own, false: none.
  bool splits_contradictory = false;
};

std::vector<Track> BuildTracks(const std::vector<VerifiedPair>& pairs,
                               const std::vector<const PhotoFeatures*>& features,
                               const std::vector<View>& views, const TrackOptions& options);

// Flatter rays than this leave the distance open.
inline constexpr double kMinAngleRad = 0.01;
// Between any two of its rays.
double WidestAngle(const std::vector<View>& views, const Track& track);

// The point nearest to all rays, and the widest angle; false when the rays are parallel or meet behind a
// camera.
bool Triangulate(const std::vector<View>& views, Track& track);

// Distance in pixels between where a photo saw a track and where it should have; infinite when it cannot see
// it.
double ReprojectionErrorPx(const View& view, const Observation& observation,
                           const Eigen::Vector3d& point_in_enu);

}  // namespace skyquilt::alignment
