// CandidatePairs: which photos are worth comparing when their attitude is unknown. Sources of pairs say which
// may show the same, each for a reason of its own; what several say is compared once. Their number grows with
// the photos. How to add one: docs/developers/recipes.md. Pure; any thread.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/alignment/matching/appearance.h"
#include "core/alignment/scene/photo_set.h"
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

struct PairQuestion {
  const Registration& input;  // its photos
  const Appearance& appearance;
  const CandidateOptions& options;
  const PhotoSet& wanted;  // only pairs with one of these; of no photos: all
  int threads = 0;

  bool IsWanted(std::size_t photo) const {
    return input.features[photo] && (wanted.Photos() == 0 || wanted.Has(photo));
  }
};

// Partners of those that are wanted, as far as the source has a say; any photo, in any order, itself and
// those beyond the last too.
using PartnersByPhoto = std::vector<std::vector<int>>;
using PairSource = PartnersByPhoto (*)(const PairQuestion&);

PartnersByPhoto NextInOrder(const PairQuestion& question);
// By recorded position, if that is right: nothing is excluded by it.
PartnersByPhoto NearestByPosition(const PairQuestion& question);
PartnersByPhoto LookingAlike(const PairQuestion& question);

inline constexpr PairSource kPairSources[] = {NextInOrder, NearestByPosition, LookingAlike};

// (first, second) with first < second, sorted; photos without features are in none.
std::vector<std::pair<int, int>> CandidatePairs(const PairQuestion& question);

}  // namespace skyquilt::alignment
