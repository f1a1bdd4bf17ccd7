// CandidatePairs: which photos are worth comparing when nobody knows how they looked: neighbours in the order of
// capture, those nearest by recorded position (if that is right; nothing is excluded by it), and those that look
// alike. Their number grows with the photos. Pure; any thread.
#pragma once

#include <utility>
#include <vector>

#include "core/alignment/registration/appearance.h"
#include "core/alignment/registration/registration.h"

namespace skyquilt::alignment {

struct CandidateOptions {
  int in_order = 4;             // before and after
  int nearest = 8;              // of those with a position
  int alike = 5;                // of photos with a position
  int alike_unplaced = 16;      // of photos without
};

// (first, second) with first < second, sorted; photos without features are in none.
std::vector<std::pair<int, int>> CandidatePairs(const std::vector<RegistrationPhoto>& photos,
                                                const Appearance& appearance, const CandidateOptions& options,
                                                int threads);

}  // namespace skyquilt::alignment
