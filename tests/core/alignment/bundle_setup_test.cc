#include "core/alignment/from_records/bundle_setup.h"

#include <gtest/gtest.h>

namespace skyquilt::alignment {
namespace {

TEST(OnlyWithinComponents, LeavesOutWhatNoVerifiedPairsHoldTogether) {
  const std::vector<VerifiedPair> links = {{0, 1, {}, {}, 0.0}, {1, 2, {}, {}, 0.0}, {3, 4, {}, {}, 0.0}};
  const std::vector<CandidatePair> pairs = {{0, 2, 0.3}, {2, 3, 0.4}, {4, 5, 0.5}};
  const std::vector<CandidatePair> want = {{0, 1, 0.0}, {0, 2, 0.3}, {1, 2, 0.0}, {3, 4, 0.0}};
  EXPECT_EQ(OnlyWithinComponents(pairs, links, 6), want);
}

}  // namespace
}  // namespace skyquilt::alignment
