// Registration: photos tied to each other by what they show alone, and the poses that follow from it, up to
// the place, direction and scale that no photo tells. Frame `world`: one for each block of photos that hang
// together; nothing is known between two blocks. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <concepts>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/tracks.h"
#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct Registration {
  // By photo, in the order of capture.
  std::vector<const PhotoFeatures*> features;  // null: takes no part
  std::vector<int> lens_of;
  std::vector<std::optional<Eigen::Vector3d>> position_in_enu;  // only says which photos may show the same
  std::vector<BundleLens> lenses;
  // The view graph: compared, with enough matches for a geometry; and verified by it, each agreeing with the
  // others, sorted by photos. As registered, those within one block.
  std::vector<PhotoPair> compared, links;
  int pairs_compared = 0, pairs_verified = 0, pairs_refused = 0;
  std::vector<KeypointTrack> scene;         // of the links, as a block is grown from them
  std::vector<std::vector<int>> tracks_of;  // by photo: those of the scene that it shows
  // As registered, not before. The first two by photo.
  std::vector<geo::Rigid3> cam_from_world;
  std::vector<int> block_of;     // 0 is the largest; negative: not registered
  std::vector<int> block_sizes;  // the largest first
  std::vector<Track> tracks;     // point_in_enu is in the world of the photos' block
  double residual_rms_px = 0.0;

  void Add(const PhotoFeatures* of_photo, int lens, const std::optional<Eigen::Vector3d>& position) {
    features.push_back(of_photo), lens_of.push_back(lens), position_in_enu.push_back(position);
  }
  std::size_t Photos() const { return features.size(); }
  const camera::Intrinsics& LensOf(std::integral auto photo) const {
    return lenses[lens_of[photo]].intrinsics;
  }
  int LargestSize() const { return block_sizes.empty() ? 0 : block_sizes.front(); }
};

}  // namespace skyquilt::alignment
