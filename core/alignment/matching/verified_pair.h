// VerifyOnGround: do the matches of two photos agree on one motion over the ground? Every match is tried as
// the motion (its place, and its direction for the turn), the one with most inliers is refined while the
// tolerance shrinks. No random numbers: the same matches give the same result. Relief moves things along the
// line between the cameras, so the tolerance is wider that way. And what photos such pairs hang together by.
// Pure; any thread.
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct VerificationOptions {
  double first_tolerance_m = 4.0;   // of a single match's motion
  double last_tolerance_m = 1.0;    // of the refined motion
  std::complex<double> baseline_m;  // from the first camera to the second, E + iN
  double search_area_m2 = 1e4;      // where a match could have lain by chance
  bool any_turn = false;            // the recorded yaw is not to be trusted
  int min_matches = 10;
};

// The similarity that maps the first of each pair nearest to its second (least squares); a mere shift where
// the places coincide.
GroundSimilarity FitSimilarity(
    const std::vector<std::pair<std::complex<double>, std::complex<double>>>& places);

std::optional<PhotoPair> VerifyOnGround(const GroundKeypoints& projected, int first, int second,
                                        const std::vector<KeypointMatch>& matches,
                                        const VerificationOptions& options);

// Of the photos and their verified pairs. What lies in two components is only as right to each other as the
// records are.
struct ConnectedComponents {
  std::vector<int> of_photo;              // negative: no verified pair
  std::vector<std::vector<int>> members;  // by component, in the photos' order
};

ConnectedComponents FindConnectedComponents(std::size_t photos, const std::vector<PhotoPair>& pairs);

}  // namespace skyquilt::alignment
