// What tracks tie: of a few photos, counted by hand, and of flights that hover, whose photos all see the
// same.
#include "core/alignment/stages/track_ties.h"

#include <gmock/gmock.h>

#include <numeric>

#include "tests/support/peak_memory.h"

namespace skyquilt::alignment {
namespace {

using ::testing::ElementsAre;

// All look along z from one place, 50 m from what they see.
BundleProblem TakenAtOnePlace(int photos) {
  BundleProblem problem;
  problem.photos.resize(photos);
  BundleLens& lens = problem.lenses.emplace_back();
  lens.recorded = lens.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  return problem;
}

// Each of the photos sees it so far beside where it is.
Track TrackOfAll(const BundleProblem& problem, const std::vector<int>& photos, double east_m,
                 const Eigen::Vector2d& beside_px) {
  Track track;
  track.point_in_enu = {east_m, 0.0, 50.0};
  const Eigen::Vector2d projected = problem.lenses[0].intrinsics.ProjectBeyondFold(track.point_in_enu);
  for (const int photo : photos)
    track.observations.push_back({photo, Eigen::Vector2d(projected + beside_px), 1.0});
  return track;
}

std::vector<int> FirstPhotos(int count) {
  std::vector<int> photos(count);
  std::iota(photos.begin(), photos.end(), 0);
  return photos;
}

TEST(PairsInUse, TellsEachPairOnceWithSomeOfItsPlacesInTheTracksOrder) {
  BundleProblem problem = TakenAtOnePlace(3);
  for (int t = 0; t < 20; ++t) {
    const std::vector<int> photos = t % 2 == 0 ? std::vector<int>{0, 1, 2} : std::vector<int>{0, 2};
    problem.tracks.push_back(TrackOfAll(problem, photos, t, {3.0, 4.0}));
  }
  problem.soft_tracks.push_back(TrackOfAll(problem, {0, 1}, 0.0, {0.0, 0.0}));
  problem.soft_tracks.push_back(TrackOfAll(problem, {1, 2}, 0.0, {3.0, 4.0}));  // does not agree
  const std::vector<AlignPairReport> pairs = PairsInUse(problem, {"a", "b", "c"});
  ASSERT_EQ(pairs.size(), 4u);
  const std::vector<std::string> expected{"a b", "a c", "b c", "a b"};
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    EXPECT_EQ(pairs[p].first + " " + pairs[p].second, expected[p]);
    EXPECT_EQ(pairs[p].is_by_direct, p == 3);
    EXPECT_NEAR(pairs[p].rms_px, p == 3 ? 0.0 : 5.0, 1e-9);
    EXPECT_NEAR(pairs[p].rms_m, p == 3 ? 0.0 : 5.0 * 50.0 / 3000.0, 1e-9);
  }
  EXPECT_EQ(pairs[0].matches, 10);
  EXPECT_EQ(pairs[1].matches, 20);
  EXPECT_EQ(pairs[2].matches, 10);
  EXPECT_EQ(pairs[3].matches, 1);
  ASSERT_EQ(pairs[0].some.size(), 5u) << "every second of ten";
  ASSERT_EQ(pairs[1].some.size(), 7u) << "every third of twenty";
  EXPECT_NEAR(pairs[0].some[1].first.x() - pairs[0].some[0].first.x(), 4 * 60.0, 1e-9);
  EXPECT_NEAR(pairs[1].some[6].second.x() - pairs[1].some[5].second.x(), 3 * 60.0, 1e-9);
}

// 24 million pairs of observations, of 32 bytes each when they were kept.
TEST(PairsInUse, TakesNoMemoryByThePairsOfEachTracksObservations) {
  constexpr int kAllHover = 400, kSeenByAll = 300;
  BundleProblem problem = TakenAtOnePlace(kAllHover);
  for (int t = 0; t < kSeenByAll; ++t)
    problem.tracks.push_back(TrackOfAll(problem, FirstPhotos(kAllHover), 0.05 * t, {1.0, 0.0}));
  const double before_mib = test::PeakMib();
  const std::vector<AlignPairReport> pairs = PairsInUse(problem, std::vector<std::string>(kAllHover, "a"));
  EXPECT_LT(test::PeakMib() - before_mib, 300.0);
  ASSERT_EQ(pairs.size(), kAllHover * (kAllHover - 1) / 2u);
  EXPECT_EQ(pairs.back().matches, kSeenByAll);
  EXPECT_EQ(pairs.back().some.size(), 9u);
}

TEST(FindAligned, CountsWhatHasEnoughTiesAndItsGroups) {
  BundleProblem problem = TakenAtOnePlace(7);
  for (int t = 0; t < 15; ++t) {
    if (t < 12) problem.tracks.push_back(TrackOfAll(problem, {0, 1, 4}, t, {3.0, 4.0}));
    if (t < 3) problem.tracks.push_back(TrackOfAll(problem, {0, 5}, t, {3.0, 4.0}));  // too few
    problem.tracks.push_back(TrackOfAll(problem, {2, 3}, t, {3.0, 4.0}));
  }
  std::vector<Support> support;
  EXPECT_THAT(FindAligned(problem, support), ElementsAre(0, 0, 1, 1, 0, -1, -1));
  std::vector<int> tied_to, observations;
  for (const Support& one : support) {
    tied_to.push_back(one.tied_to);
    observations.push_back(one.observations);
  }
  EXPECT_THAT(tied_to, ElementsAre(2, 2, 1, 1, 2, 0, 0));
  EXPECT_THAT(observations, ElementsAre(12, 12, 15, 15, 12, 0, 0));
  EXPECT_NEAR(support[0].square_px, 12 * 25.0, 1e-6);
}

TEST(FindAligned, TakesNoMemoryByThePairsOfPhotosThatHover) {
  constexpr int kAtOnePlace = 1500;
  BundleProblem problem = TakenAtOnePlace(kAtOnePlace);
  for (int t = 0; t < kEnoughObservations; ++t)
    problem.tracks.push_back(TrackOfAll(problem, FirstPhotos(kAtOnePlace), t, {0.0, 0.0}));
  const double before_mib = test::PeakMib();
  std::vector<Support> support;
  const std::vector<int> component = FindAligned(problem, support);
  EXPECT_LT(test::PeakMib() - before_mib, 100.0);
  EXPECT_EQ(component, std::vector<int>(kAtOnePlace, 0));
  EXPECT_EQ(support.back().tied_to, kAtOnePlace - 1);
}

}  // namespace
}  // namespace skyquilt::alignment
