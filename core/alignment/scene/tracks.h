// Tracks: one point on the ground and the keypoints of several photos that see it: built from pairwise
// matches between photos whose poses are known (BuildTracks) or are not (JoinMatches), and what such tracks
// are chosen and placed with. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/view.h"
#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

struct TrackElement {
  int photo = 0;
  int keypoint = 0;
};

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

// Of a keypoint of that photo: worse located than its finest where it stands for a large patch.
Observation ObservationOf(const PhotoFeatures& features, const TrackElement& element);

// Which of so many photos see any of the tracks.
PhotoSet ObservingPhotos(std::size_t photos, const std::vector<Track>& tracks);

// Those whose rays meet at an angle that tells their heights.
std::vector<Eigen::Vector3d> PointsWithHeights(const std::vector<Track>& tracks);
// Photos that see fewer are not held by them.
inline constexpr int kEnoughObservations = 12;

struct TrackOptions {
  int observations_per_photo = 220;  // as an adjustment takes them
  // Chains of matches that lead to two places of one photo are of no use as they are; true: each of their
  // matches becomes a track of its own, false: none.
  bool splits_contradictory = false;
};

// Thinned so that every photo keeps as many as the options say, spread over its picture. Observations in the
// order of the photos.
std::vector<Track> BuildTracks(const std::vector<PhotoPair>& pairs,
                               const std::vector<const PhotoFeatures*>& features,
                               const std::vector<View>& views, const TrackOptions& options);

// Flatter rays than this leave the distance open.
inline constexpr double kMinAngleRad = 0.01;
// Between any two of its rays.
double WidestAngle(const std::vector<View>& views, const Track& track);

// The point nearest to all rays, and the widest angle; false when the rays are parallel or meet behind a
// camera.
bool Triangulate(const std::vector<View>& views, Track& track);

// The same of those of its observations that agree: the one with the largest error, in its sigmas, goes until
// none is larger than `max_sigmas`.
bool TriangulateAgreed(const std::vector<View>& views, double max_sigmas, Track& track);

// Distance in pixels between where a photo saw a track and where it should have; infinite when it cannot see
// it.
double ReprojectionErrorPx(const View& view, const Observation& observation,
                           const Eigen::Vector3d& point_in_enu);

// A track while photos are being placed: each photo at most once, in their order. By keypoints, a sixth of an
// observation's size: all of a flight's are kept.
using KeypointTrack = std::vector<TrackElement>;

// By the matches of the best supported pair first. A match that would put one point at two places of one
// photo is skipped, so that a wrong chain of matches loses one match, not the whole track. features: by
// photo; null: it takes no part.
std::vector<KeypointTrack> JoinMatches(const std::vector<const PhotoFeatures*>& features,
                                       const std::vector<PhotoPair>& pairs);

// Which of many tracks an adjustment takes, so that every photo keeps a few, spread over its picture: every
// cell of a photo gets one track before any gets the next, in the order in which tracks were added. One
// thread.
class TrackSpread {
 public:
  TrackSpread(std::size_t photos, int observations_per_photo, int cells_across);

  // The next track. Then once for each photo that sees it and has a say in what is taken.
  void BeginTrack() { begins_.push_back(seen_.size()); }
  void SeenBy(int photo, const Eigen::Vector2d& pixel_in_image, const camera::Intrinsics& lens);

  // By the order in which they were added, ascending.
  std::vector<std::size_t> Choose() const;

 private:
  struct PhotoCell {
    std::size_t photo, cell;  // the cell counts through all photos
  };

  std::size_t photos_, cells_across_;
  int observations_per_photo_;
  std::vector<PhotoCell> seen_;      // of all tracks, one after the other
  std::vector<std::size_t> begins_;  // of each track, in seen_
};

// Two of several rays at an angle that tells how far they go. Rays may go one by one, as others are found
// further off: the search goes on from where it was, so that all that go cost the square of the rays, not the
// cube. One thread.
class WidePair {
 public:
  explicit WidePair(double min_angle_rad) : max_cosine_(std::cos(min_angle_rad)) {}

  // Of unit length; the same as before but for those that went.
  bool IsAmong(const std::vector<Eigen::Vector3d>& rays) {
    while (one_ < rays.size() && !(rays[one_].dot(rays[other_]) <= max_cosine_)) {
      if (++other_ == one_) ++one_, other_ = 0;
    }
    return one_ < rays.size();
  }
  void TakeOut(std::size_t ray) {
    if (ray == one_) other_ = 0;
    if (ray < other_) --other_;
    if (ray < one_ && --one_ == other_) ++one_, other_ = 0;
  }

 private:
  double max_cosine_;
  std::size_t one_ = 1, other_ = 0;  // no two before them are
};

// The point nearest to all of several rays (least squares of the distances across). One thread.
class RayIntersection {
 public:
  // `ray`: of length 1, from `center` on.
  void Add(const Eigen::Vector3d& center, const Eigen::Vector3d& ray);
  // Of two rays or more that are not parallel.
  Eigen::Vector3d Point() const;

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

}  // namespace skyquilt::alignment
