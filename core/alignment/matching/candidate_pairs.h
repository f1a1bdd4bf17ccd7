// CandidatePairs: which photos are worth comparing when their attitude is unknown: neighbours in the order
// of capture, those nearest by recorded position (if that is right; nothing is excluded by it), and those
// that look alike. Their number grows with the photos. Pure; any thread.
#pragma once

#include <utility>
#include <vector>

#include "core/alignment/matching/appearance.h"
#include "core/alignment/scene/registration.h"

namespace skyquilt::alignment {

struct CandidateOptions {
  std::vector<int> steps{1, 2, 4};  // in the order of capture
  int nearest = 5;                  // of those with a position
  int alike = 3;                    // of photos with a position
  int alike_unplaced = 7;           // of photos without
  // Of photos that look alike, those taken one after another stand for each other, and those taken next to
  // the photo itself are compared anyway: the other lines that pass here are wanted.
  int apart_in_order = 3;

  // For photos that those leave with few partners.
  static CandidateOptions Generous() { return {{1, 2, 3, 4, 6}, 10, 10, 20, 0}; }
};

// (first, second) with first < second, sorted; photos without features are in none. `wanted`: only pairs of
// which one is marked; empty: all.
std::vector<std::pair<int, int>> CandidatePairs(const std::vector<RegistrationPhoto>& photos,
                                                const Appearance& appearance, const CandidateOptions& options,
                                                const std::vector<char>& wanted, int threads);

}  // namespace skyquilt::alignment
