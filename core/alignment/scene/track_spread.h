// TrackSpread: which of many tracks an adjustment takes, so that every photo keeps a few, spread over its
// picture: every cell of a photo gets one track before any gets the next, in the order in which tracks were
// added. One thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

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

}  // namespace skyquilt::alignment
