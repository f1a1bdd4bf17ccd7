#include "core/alignment/matching/verified_pair.h"

#include <gtest/gtest.h>

#include <random>

#include "core/alignment/scene/matches.h"

namespace skyquilt::alignment {
namespace {

// Two photos of one ground, 80 m wide; matches of the second lie around the first's by `residual`.
struct Matched {
  PhotoFeatures features;
  std::vector<GroundKeypoint> first, second;
  std::vector<KeypointMatch> matches;

  template <typename Residual>
  Matched(int count, const Residual& residual) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(0.0, 80.0);
    for (int i = 0; i < count; ++i) {
      const std::complex<double> at(place(random), place(random));
      first.push_back({at, 0.0F, 0.0F, true});
      second.push_back({at + residual(random), 0.0F, 0.0F, true});
      matches.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i)});
    }
  }
  std::optional<VerifiedPair> Fit(const VerificationOptions& options) const {
    return VerifyOnGround({&features, &first}, {&features, &second}, matches, options);
  }
};

// A window of 4.5 m after a first correction, cameras 30 m apart.
VerificationOptions NarrowWindow() {
  VerificationOptions options;
  options.first_tolerance_m = 2.2;
  options.last_tolerance_m = 1.0;
  options.baseline_m = {30.0, 0.0};
  options.search_area_m2 = 64.0;
  options.min_matches = 8;
  return options;
}

TEST(VerifyOnGround, FollowsAgreeingMatchesInANarrowWindowBetweenDistantCameras) {
  std::normal_distribution<double> noise(0.0, 0.4);
  const Matched matched(200, [&](std::mt19937& random) {
    return std::complex<double>(3.0 + noise(random), -1.0 + noise(random));
  });
  const auto pair = matched.Fit(NarrowWindow());
  ASSERT_TRUE(pair.has_value());
  EXPECT_GT(pair->matches.size(), 180u);
  EXPECT_LT(
      std::abs(pair->second_from_first * std::complex<double>(40.0, 40.0) - std::complex<double>(43.0, 39.0)),
      0.2);
}

TEST(VerifyOnGround, RefusesMatchesThatFillTheWindowByChance) {
  std::uniform_real_distribution<double> anywhere(-4.0, 4.0);
  const Matched matched(
      300, [&](std::mt19937& random) { return std::complex<double>(anywhere(random), anywhere(random)); });
  EXPECT_FALSE(matched.Fit(NarrowWindow()).has_value());
}

}  // namespace
}  // namespace skyquilt::alignment
