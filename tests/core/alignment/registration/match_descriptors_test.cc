#include "core/alignment/matching/match_descriptors.h"

#include <gtest/gtest.h>

#include "core/alignment/estimators/sampler.h"

namespace skyquilt::alignment {
namespace {

Descriptor UniformDescriptor(Sampler& sampler) {
  Descriptor descriptor{};
  for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(sampler.Below(90));
  return descriptor;
}

PhotoFeatures Features(int count, std::uint64_t seed) {
  Sampler sampler(seed);
  PhotoFeatures features;
  for (int k = 0; k < count; ++k) {
    features.keypoints.push_back({static_cast<float>(20 * k), 10.0F, 0.0F, 5.0F});
    features.descriptors.push_back(UniformDescriptor(sampler));
  }
  return features;
}

TEST(MatchDescriptors, FindsWhatIsTheSameInAnyOrder) {
  const PhotoFeatures first = Features(37, 1);
  PhotoFeatures second = Features(50, 2);
  for (int k = 0; k < 20; ++k) {
    second.descriptors[49 - k] = first.descriptors[k];
    second.descriptors[49 - k][k] = static_cast<std::uint8_t>(second.descriptors[49 - k][k] + 5);
  }
  const std::vector<KeypointMatch> matches = MatchDescriptors(first, second);
  ASSERT_GE(matches.size(), 20U);
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(matches[k].first, k);
    EXPECT_EQ(matches[k].second, 49 - k);
  }
}

TEST(MatchDescriptors, RefusesWhatRepeatsElsewhereInEitherPhoto) {
  const PhotoFeatures first = Features(10, 1);
  PhotoFeatures second = Features(10, 2);
  second.descriptors[3] = second.descriptors[7] = first.descriptors[0];
  for (const KeypointMatch& match : MatchDescriptors(first, second)) EXPECT_NE(match.first, 0);
  for (const KeypointMatch& match : MatchDescriptors(second, first)) EXPECT_NE(match.second, 0);
}

TEST(MatchDescriptors, OnePlaceDescribedTwiceIsNoRivalOfItself) {
  const PhotoFeatures first = Features(10, 1);
  PhotoFeatures second = Features(10, 2);
  second.descriptors[3] = second.descriptors[7] = first.descriptors[0];
  second.keypoints[7] = second.keypoints[3];
  second.keypoints[7].x_px += 1.0F;
  int found = 0;
  for (const KeypointMatch& match : MatchDescriptors(first, second)) found += match.first == 0 ? 1 : 0;
  EXPECT_EQ(found, 1);
}

TEST(MatchDescriptors, TakesOnlyTheFirstFeaturesAsked) {
  const PhotoFeatures first = Features(30, 1);
  for (const KeypointMatch& match : MatchDescriptors(first, first, 8)) EXPECT_LT(match.first, 8);
  EXPECT_EQ(MatchDescriptors(first, first, 8).size(), 8U);
  EXPECT_TRUE(MatchDescriptors(first, PhotoFeatures{}, 8).empty());
}

}  // namespace
}  // namespace skyquilt::alignment
