// What an adjusted problem's tracks tie: which photos count as aligned and in which groups, and by how much
// each two hold together. A track of a flight that hovers is seen by hundreds of photos and ties each two of
// them: memory grows with the observations and with what is told, not with every track's pairs of these.
// Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/align_report.h"

namespace skyquilt::alignment {

// Of a photo, by tracks that it shares with others that have enough.
struct Support {
  int observations = 0;
  double square_px = 0.0;  // of their reprojection errors
  int tied_to = 0;         // others
};

// Photos with enough ties, in components; -1 for the others. Weak photos lend no support to others.
std::vector<int> FindAligned(const BundleProblem& problem, std::vector<Support>& support);

// Which photos hold an adjusted block together, by how many matches and how well these agree; with some of
// the matches, so that truth can judge them. Sorted by the photos' order; ties by whole pictures after those
// by points, and only those that agree with where the photos lie.
std::vector<AlignPairReport> PairsInUse(const BundleProblem& problem, const std::vector<std::string>& names);

}  // namespace skyquilt::alignment
