// Registration: photos tied to each other by what they show alone, and the poses that follow from it, up to
// the place, direction and scale that no photo tells. Frame `world`: one for each block of photos that hang
// together; nothing is known between two blocks. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>
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

  // Makes the largest block number 0, and so on; equals stay in their order.
  void NumberBySize() {
    std::vector<int> by_size(block_sizes.size());
    std::iota(by_size.begin(), by_size.end(), 0);
    std::stable_sort(by_size.begin(), by_size.end(),
                     [&](int a, int b) { return block_sizes[a] > block_sizes[b]; });
    std::vector<int> number(by_size.size()), sizes;
    for (const int block : by_size) {
      number[block] = static_cast<int>(sizes.size());
      sizes.push_back(block_sizes[block]);
    }
    for (int& block : block_of) {
      if (block >= 0) block = number[block];
    }
    block_sizes = std::move(sizes);
  }
};

}  // namespace skyquilt::alignment
