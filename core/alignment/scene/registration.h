// Registration: photos tied to each other by what they show alone, and the poses that follow from it, up to
// the place, direction and scale that no photo tells. Frame `world`: one for each block of photos that hang
// together; nothing is known between two blocks. Values; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/tracks.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct RegistrationPhoto {
  const PhotoFeatures* features = nullptr;  // null: takes no part
  int lens = 0;
  std::optional<Eigen::Vector3d> position_in_enu;  // only says which photos may show the same
  // As registered, not before.
  geo::Rigid3 cam_from_world;
  int block = -1;                // 0 is the largest; negative: not registered
  std::vector<int> tracks = {};  // before: those of the scene that it shows
};

struct Registration {
  std::vector<RegistrationPhoto> photos;  // in the order of capture
  std::vector<BundleLens> lenses;
  // The view graph: compared, with enough matches for a geometry; and verified by it, each agreeing with the
  // others, sorted by photos. As registered, those within one block.
  std::vector<PhotoPair> compared, links;
  int pairs_compared = 0, pairs_verified = 0, pairs_refused = 0;
  std::vector<KeypointTrack> scene;  // of the links, as a block is grown from them
  // As registered, not before.
  std::vector<int> block_sizes;  // the largest first
  std::vector<Track> tracks;     // point_in_enu is in the world of the photos' block
  double residual_rms_px = 0.0;

  int LargestSize() const { return block_sizes.empty() ? 0 : block_sizes.front(); }
  // By photo.
  std::vector<const PhotoFeatures*> Features() const {
    std::vector<const PhotoFeatures*> features;
    for (const RegistrationPhoto& photo : photos) features.push_back(photo.features);
    return features;
  }
};

}  // namespace skyquilt::alignment
