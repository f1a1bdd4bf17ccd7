// MatchAndVerify: matches candidate pairs and fits a motion over the ground to each, in parallel over pairs.
// MatchLostPhotos does it without believing position or yaw, for photos that should have found their
// neighbours and did not. Same result for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/matching/pair_selection.h"
#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
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

struct MatchingInput {
  std::vector<const PhotoFeatures*> features;  // null: unreadable
  std::vector<View> views;
  std::vector<double> ground_sigma_m;
  std::vector<double> sigma_turn_rad;
};

// By photo; those that could not be read have no features.
std::vector<GroundView> ProjectAllToGround(const MatchingInput& input, const Relief& relief, int threads);

std::vector<PhotoPair> MatchAndVerify(const MatchingInput& input, const std::vector<GroundView>& projected,
                                      const std::vector<CandidatePair>& pairs, const MatchingPass& pass,
                                      int threads);

// `tried` are the candidates matched so far, `verified` those of them that were verified.
std::vector<PhotoPair> MatchLostPhotos(const MatchingInput& input, const std::vector<GroundView>& projected,
                                       const std::vector<CandidatePair>& tried,
                                       const std::vector<PhotoPair>& verified, int threads);

}  // namespace skyquilt::alignment
