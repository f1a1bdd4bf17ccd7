#include "core/poses/evidence/assumption.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::poses {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<Assumption> kBoth = {
    {"No height is recorded.", "91 m is assumed.", 91.0},
    {"No angles are recorded.", "Straight down is assumed.", std::nullopt}};

TEST(Assumption, StandsWherePosesAlonePlaceThePhotos) {
  EXPECT_EQ(InWords(AssumptionsByPoses(kBoth)).front(), "No height is recorded. 91 m is assumed.");
}

TEST(Assumption, IsNotStatedAsAFactWhereThePhotosShowedBetter) {
  const std::vector<std::string> words = InWords(AssumptionsAfterAlignment(kBoth, 40.2, 0));
  EXPECT_THAT(words, ElementsAre(HasSubstr("it was 40 m"), HasSubstr("found from what they show")));
  for (const std::string& one : words) EXPECT_THAT(one, Not(HasSubstr("is assumed")));
}

TEST(Assumption, StillHoldsForPhotosByPoseAlone) {
  EXPECT_THAT(InWords(AssumptionsAfterAlignment(kBoth, 40.2, 3)),
              ElementsAre(HasSubstr("For the 3 photos"), HasSubstr("Straight down is assumed.")));
}

}  // namespace
}  // namespace skyquilt::poses
