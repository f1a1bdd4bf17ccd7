// PairsInUse: which photos hold an adjusted block together, by how many matches and how well these agree;
// with some of the matches, so that truth can judge them. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/align_report.h"

namespace skyquilt::alignment {

// Sorted by the photos' order; ties by whole pictures after those by points, and only those that agree with
// where the photos lie.
std::vector<AlignPairReport> PairsInUse(const BundleProblem& problem, const std::vector<std::string>& names);

}  // namespace skyquilt::alignment
