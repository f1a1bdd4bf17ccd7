// MatchAndVerify: matches candidate pairs and fits a motion over the ground to each, in parallel over pairs.
// MatchLostPhotos does it without believing position or yaw, for photos that should have found their
// neighbours and did not. Same result for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/matching/pair_selection.h"
#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct MatchingPass {
  double min_radius_share = 0.10;  // of the photo's width on the ground
  double sigmas = 3.0;             // of the joint uncertainty on the ground; 0 = min_radius_share alone
  double max_turn_rad = 0.6;
  double tolerance_share = 0.015;  // of the width; inlier tolerance of the fitted motion
  double max_distance_ratio = 0.85;
  int min_matches = 10;
  bool fit_motion = true;  // false: take every match, the window is narrow enough
};

// The photos that are to be compared, as they lie so far, and what came of it.
struct MatchedFlight {
  // By photo.
  std::vector<const PhotoFeatures*> features;  // null: unreadable
  std::vector<View> views;
  std::vector<double> ground_sigma_m;
  std::vector<double> sigma_turn_rad;
  std::vector<PhotoFindings> findings;
  std::vector<PhotoPair> pairs;  // candidates of the last pass
  std::vector<PhotoPair> links;  // verified, and not contradicted by the others
};

GroundKeypoints ProjectAllToGround(const MatchedFlight& input, const Relief& relief, int threads);

// Of the pairs of the flight.
std::vector<PhotoPair> MatchAndVerify(const MatchedFlight& input, const GroundKeypoints& projected,
                                      const MatchingPass& pass, int threads);

// `verified`: those of the pairs that were, so far.
std::vector<PhotoPair> MatchLostPhotos(const MatchedFlight& input, const GroundKeypoints& projected,
                                       const std::vector<PhotoPair>& verified, int threads);

}  // namespace skyquilt::alignment
