#include "core/alignment/matching/appearance.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/core/alignment/registration/synthetic_scene.h"

namespace skyquilt::alignment {
namespace {

TEST(Appearance, PhotosThatOverlapMostAreMostAlike) {
  const SyntheticScene scene = MakeScene({.columns = 12, .rows = 1});
  std::vector<const PhotoFeatures*> features;
  for (const PhotoFeatures& photo : scene.features) features.push_back(&photo);
  const Appearance appearance = Appearance::Learn(features, 1);
  int near = 0;
  const std::vector<std::vector<int>> alike = appearance.MostAlike(2, 1);
  for (int i = 0; i < 12; ++i) {
    ASSERT_EQ(alike[i].size(), 2U);
    for (const int j : alike[i]) near += std::abs(i - j) <= 2 ? 1 : 0;
  }
  EXPECT_GE(near, 22);
  EXPECT_EQ(alike, Appearance::Learn(features, 3).MostAlike(2, 3));
}

TEST(Appearance, APhotoWithoutFeaturesIsLikeNone) {
  const SyntheticScene scene = MakeScene({.columns = 3, .rows = 1});
  const PhotoFeatures empty;
  const Appearance appearance =
      Appearance::Learn({&scene.features[0], nullptr, &scene.features[1], &empty}, 1);
  const std::vector<std::vector<int>> alike = appearance.MostAlike(5, 1);
  EXPECT_EQ(alike[0], std::vector<int>{2});
  EXPECT_TRUE(alike[1].empty());
  EXPECT_TRUE(alike[3].empty());
  EXPECT_TRUE(Appearance::Learn({nullptr, nullptr}, 1).MostAlike(2, 1)[0].empty());
}

}  // namespace
}  // namespace skyquilt::alignment
