// RegisterByResection: a pose for photos without verified pairs, from the aligned photos around them. What
// all of those show in common with the lost one is used for one pose: each match is a pixel of the
// lost photo and the place on the ground where a neighbour saw the same, and the pose with most inliers
// is found by resection (three points, RANSAC with a fixed seed). Ten matches with each of four neighbours
// suffice where no single pair would, and the record may be far off. Same result for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {

struct ResectedPhoto {
  int photo = 0;
  geo::Rigid3 cam_from_enu;
  std::vector<VerifiedPair> links;  // verified, with the neighbours that have inliers
};

// `input.views` are the adjusted ones; `is_aligned` says which photos' views are to be believed.
// `expected_error_m`: how far off the views of the others may be on the ground, one sigma.
std::vector<ResectedPhoto> RegisterByResection(const MatchingInput& input, const Relief& relief,
                                               const std::vector<char>& is_aligned, double expected_error_m,
                                               int threads);

}  // namespace skyquilt::alignment
