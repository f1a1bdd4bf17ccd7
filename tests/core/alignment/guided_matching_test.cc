// Pairs of photos compared where their poses put them: matching, verification, what hangs together.
#include "core/alignment/matching/guided_matching.h"

#include <gtest/gtest.h>

#include <random>
#include <tuple>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/matching/verified_pair.h"

namespace skyquilt::alignment {
namespace {

// The keypoints of one photo with their places on the ground.
struct Side {
  PhotoFeatures features;
  std::vector<GroundKeypoint> projected;

  void Add(std::complex<double> place, const Descriptor& descriptor, float angle_rad = 0.0F,
           float log2_scale = 0.0F) {
    Keypoint keypoint;
    keypoint.x_px = 40.0F * static_cast<float>(projected.size());  // no two are one place of the photo
    keypoint.scale_px = 10.0F;
    features.keypoints.push_back(keypoint);
    features.descriptors.push_back(descriptor);
    projected.push_back({place, angle_rad, log2_scale, true});
  }
};

std::vector<KeypointMatch> Match(const Side& a, const Side& b, const MatchWindow& window) {
  return MatchOnGround({&a.features, &b.features}, {a.projected, b.projected}, 0, 1, window);
}

Descriptor RandomDescriptor(std::mt19937& random) {
  std::uniform_int_distribution<int> value(0, 60);
  Descriptor descriptor{};
  for (auto& bin : descriptor) bin = static_cast<std::uint8_t>(value(random));
  return descriptor;
}

MatchWindow Within(double radius_m) {
  MatchWindow window;
  window.radius_m = radius_m;
  return window;
}

class MatchOnGroundTest : public testing::Test {
 protected:
  MatchOnGroundTest() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(0.0, 50.0);
    for (int i = 0; i < 40; ++i) {
      const std::complex<double> at(place(random), place(random));
      const Descriptor descriptor = RandomDescriptor(random);
      first_.Add(at, descriptor);
      second_.Add(at + std::complex<double>(1.0, -0.5), descriptor);
    }
  }
  Side first_, second_;
};

TEST_F(MatchOnGroundTest, FindsTheSameKeypointInsideTheWindow) {
  const auto matches = Match(first_, second_, Within(2.0));
  ASSERT_EQ(matches.size(), 40u);
  for (const KeypointMatch& match : matches) EXPECT_EQ(match.first, match.second);
}

TEST_F(MatchOnGroundTest, FindsNothingBeyondTheWindow) {
  for (GroundKeypoint& keypoint : second_.projected) keypoint.place += 200.0;
  EXPECT_TRUE(Match(first_, second_, Within(2.0)).empty());
}

TEST_F(MatchOnGroundTest, RefusesAnotherDirectionAndAnotherSize) {
  for (int i = 0; i < 10; ++i) second_.projected[static_cast<std::size_t>(i)].angle_rad = 1.0F;
  for (int i = 10; i < 15; ++i) second_.projected[static_cast<std::size_t>(i)].log2_scale = 1.5F;
  MatchWindow window = Within(2.0);
  window.max_turn_rad = 0.5;
  for (const KeypointMatch& match : Match(first_, second_, window)) {
    EXPECT_GE(match.first, 15);
  }
}

TEST_F(MatchOnGroundTest, RefusesRepetitiveTexture) {
  // A copy of the first keypoint half a metre beside it, at another place of the photo: neither stands out.
  first_.features.descriptors[0][0] += 5;  // no two photos show it exactly alike
  second_.Add(second_.projected[0].place + 0.5, second_.features.descriptors[0]);
  const auto matches = Match(first_, second_, Within(2.0));
  EXPECT_EQ(matches.size(), 39u);
  for (const KeypointMatch& match : matches) EXPECT_NE(match.first, 0);
}

TEST_F(MatchOnGroundTest, TakesNoMoreThanTheStrongestFeatures) {
  MatchWindow window = Within(2.0);
  window.max_features = 12;
  EXPECT_EQ(Match(first_, second_, window).size(), 12u);
}

TEST_F(MatchOnGroundTest, LeavesOutKeypointsThatAreNotOnTheGround) {
  first_.projected[3].is_on_ground = false;
  second_.projected[7].is_on_ground = false;
  for (const KeypointMatch& match : Match(first_, second_, Within(2.0))) {
    EXPECT_NE(match.first, 3);
    EXPECT_NE(match.first, 7);
  }
  const Side nothing;
  EXPECT_TRUE(Match(nothing, second_, Within(2.0)).empty());
  EXPECT_TRUE(Match(first_, nothing, Within(2.0)).empty());
}

// Two photos of one ground, 80 m wide; matches of the second lie around the first's by `residual`.
struct Matched {
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
  std::optional<PhotoPair> Fit(const VerificationOptions& options) const {
    return VerifyOnGround({first, second}, 0, 1, matches, options);
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

TEST(OnlyWithinComponents, LeavesOutWhatNoVerifiedPairsHoldTogether) {
  const std::vector<PhotoPair> links = {{0, 1, {}, {}, 0.0}, {1, 2, {}, {}, 0.0}, {3, 4, {}, {}, 0.0}};
  const std::vector<PhotoPair> pairs = {{.first = 0, .second = 2, .overlap = 0.3},
                                        {.first = 2, .second = 3, .overlap = 0.4},
                                        {.first = 4, .second = 5, .overlap = 0.5}};
  std::vector<std::tuple<int, int, double>> kept;
  for (const PhotoPair& pair : OnlyWithinComponents(pairs, links, 6))
    kept.emplace_back(pair.first, pair.second, pair.overlap);
  const std::vector<std::tuple<int, int, double>> want = {{0, 1, 0.0}, {0, 2, 0.3}, {1, 2, 0.0}, {3, 4, 0.0}};
  EXPECT_EQ(kept, want);
}

}  // namespace
}  // namespace skyquilt::alignment
