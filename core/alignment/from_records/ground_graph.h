// SolveGroundGraph: one small correction per photo (a turn, a scale and a shift of its ground) that makes all
// pairs agree, while most photos stay where their pose says. Finds what single pairs cannot: photos stored
// turned, whole lines turned, positions far off, and pairs that contradict the others. Positions decide, not
// the recorded yaw. Method: spanning tree from the photos whose pairs agree with their poses (components
// without such photos are fitted to the recorded positions by a similarity), then iteratively reweighted
// least squares in complex numbers, Cauchy weights on pairs and priors. Pure; any thread; no random numbers.
#pragma once

#include <complex>
#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

// A photo's ground: what is believed of it before the images are compared, and what they then correct of it.
struct PhotoGround {
  std::complex<double> middle;  // where its optical axis meets the ground, E + iN
  double sigma_m = 2.0;         // of the middle
  double sigma_turn_rad = 0.05;
  // By which its pairs may contradict others by more than those of most photos: it was taken from above them.
  double coarseness = 1.0;
  GroundSimilarity correction = {};  // z -> turn_and_scale * (z - middle) + middle + shift
  int component = -1;                // photos with the same number are connected; negative: no pair

  // The correction as a motion of all the ground, z -> turn_and_scale * z + shift.
  GroundSimilarity Motion() const;
  void SetMotion(const GroundSimilarity& motion);
};

// The component of a photo without pairs that takes over what its flight line has in common.
inline constexpr int kInheritedComponent = -2;

struct GroundGraph {
  std::vector<PhotoGround> photos;
  std::vector<bool> is_inlier;  // one per pair: false = contradicted by the others
};

// `pairs` whose turn is near zero are trusted as starting points; the others only connect further photos.
// Corrections that the photos came with do not count.
GroundGraph SolveGroundGraph(std::vector<PhotoGround> believed, const std::vector<PhotoPair>& pairs,
                             const GroundKeypoints& projected, double tolerance_m);

}  // namespace skyquilt::alignment
