// What recorded positions are taken to have in common.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/flight/logs/flight_log.h"
#include "core/flight/remarks/remark_words.h"
#include "core/poses/evidence/assumption.h"
#include "core/poses/evidence/common_error.h"

namespace skyquilt::poses {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<flight::GnssSample> Fixes(int count, bool is_rtk, std::optional<double> sigma_m) {
  flight::GnssSample one;
  one.is_rtk_fixed = is_rtk;
  one.sigma_horizontal_m = sigma_m;
  return std::vector<flight::GnssSample>(static_cast<std::size_t>(count), one);
}

std::vector<flight::GnssSample> operator+(std::vector<flight::GnssSample> a,
                                          const std::vector<flight::GnssSample>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(CommonError, IsAssumedWhereNothingStatesIt) {
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, std::nullopt)), (CommonError{false, 1.5}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, std::nullopt)), (CommonError{true, 0.02}));
  EXPECT_EQ(CommonErrorOf(std::vector<flight::GnssSample>()), CommonError());
}

TEST(CommonError, IsWhatMostPositionsStateWithinReason) {
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 4.0)), (CommonError{false, 4.0}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 0.2)), (CommonError{false, 0.3}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 1e9)), (CommonError{false, 15.0}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, 0.05)), (CommonError{true, 0.05}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, 0.001)), (CommonError{true, 0.02}));
  // A list computed afterwards (PPK) names no fix, and states centimetres.
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 0.03)), (CommonError{true, 0.03}));
  // One of ten speaks for itself alone.
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, std::nullopt) + Fixes(1, true, 0.01)), (CommonError{false, 1.5}));
  // No receiver knows its place so well: these are no statements.
  for (const double sigma_m : {-1.0, 0.0, 1e-6, 0.001}) {
    EXPECT_EQ(CommonErrorOf(Fixes(9, false, sigma_m)), (CommonError{false, 1.5})) << sigma_m;
  }
}

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
