// Block: photos placed to each other and the points they see, while the block grows. Frame `world`, its own:
// half of the points lie kMedianDepth before the cameras, so that numbers stay of one size. Points follow
// from poses: after moving photos, triangulate again. Const methods: any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/registration.h"
#include "core/alignment/scene/tracks.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

inline constexpr double kMedianDepth = 50.0;

class Block {
 public:
  // What a block holds, by its own photos and points alone: of many blocks beside each other none takes
  // memory for each track of the scene.
  struct Packed {
    struct Placed {
      int photo = 0;
      geo::Rigid3 cam_from_world;
    };
    struct Known {
      int track = 0;
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      std::vector<int> seen_by;
    };

    std::vector<BundleLens> lenses;
    std::vector<Placed> photos;  // ascending, as points are by their tracks
    std::vector<Known> points;

    bool Has(std::integral auto photo) const {
      return std::ranges::binary_search(photos, static_cast<int>(photo), {}, &Placed::photo);
    }
    int size() const { return static_cast<int>(photos.size()); }
  };

  // Keeps a reference to the input, whose scene it is grown from.
  Block(const Registration& input, std::vector<BundleLens> lenses);
  // The same to the last bit as the one that was packed.
  Block(const Registration& input, const Packed& packed);
  Packed Pack() const;

  bool Has(std::integral auto photo) const { return placed_.Has(photo); }
  int size() const { return placed_.Count(); }
  const geo::Rigid3& Pose(std::integral auto photo) const { return cam_from_world_[photo]; }
  const camera::Intrinsics& Lens(int photo) const;
  const std::vector<BundleLens>& lenses() const { return lenses_; }
  const Registration& input() const { return *input_; }
  const std::vector<KeypointTrack>& scene() const { return input_->scene; }

  void Place(int photo, const geo::Rigid3& cam_from_world);
  void Remove(std::integral auto photo) { placed_.Remove(photo); }

  // Points from all placed photos that agree on them.
  void TriangulateAll(int threads);
  void TriangulateSeenBy(const std::vector<int>& photos, int threads);
  bool HasPoint(std::integral auto track) const { return !seen_by_[track].empty(); }
  const Eigen::Vector3d& Point(std::integral auto track) const { return point_[track]; }
  // Indices into the track of the observations that agree.
  const std::vector<int>& SeenBy(std::integral auto track) const { return seen_by_[track]; }
  Observation ObservationOf(const TrackElement& element) const;

  // Bundle adjustment of `free` photos (all: an empty list), the others fixed and no lens adjusted; points
  // are triangulated anew.
  void Adjust(const std::vector<int>& free, BundleOptions options, int observations_per_photo, int threads);

  // Of the size above, with the cameras about the origin.
  void Normalise();

  // Points that a photo sees in agreement with others.
  std::vector<int> PointsSeen() const;
  // In pixels; 0 where it sees none.
  std::vector<double> ResidualsPx() const;
  // As the adjustment takes them.
  std::vector<Track> Tracks() const;

 private:
  void Triangulate(int track);
  void TriangulateEach(const std::vector<int>& tracks, int threads);
  Track TrackOf(int track) const;
  void FindRays(int photo);
  double ResidualSigmas(const TrackElement& element, const Eigen::Vector3d& point) const;
  std::vector<int> ChooseTracks(const PhotoSet& adjusted, int observations_per_photo) const;

  const Registration* input_;
  std::vector<BundleLens> lenses_;
  PhotoSet placed_;
  std::vector<geo::Rigid3> cam_from_world_;
  std::vector<std::vector<Eigen::Vector3d>> rays_;  // unit, in cam; of placed photos, by their tracks' order
  std::vector<Eigen::Vector3d> point_;
  std::vector<std::vector<int>> seen_by_;
};

}  // namespace skyquilt::alignment
