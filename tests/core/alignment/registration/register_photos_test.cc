#include "core/alignment/from_images/register_photos.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "core/alignment/estimators/similarity.h"
#include "core/alignment/from_images/grow_groups.h"
#include "core/alignment/from_images/join_groups.h"
#include "tests/core/alignment/registration/synthetic_scene.h"

namespace skyquilt::alignment {
namespace {

struct Judged {
  int in_first_block = 0;
  double worst_center_m = 0.0;
  double worst_turn_rad = 0.0;
};

Judged Judge(const SyntheticScene& scene, const Registration& found) {
  Judged judged;
  std::vector<PlacePair> pairs;
  std::vector<std::size_t> photos;
  for (std::size_t i = 0; i < scene.cam_from_enu.size(); ++i) {
    if (found.block_of[i] != 0) continue;
    pairs.push_back({found.cam_from_world[i].TargetOriginInSource(),
                     scene.cam_from_enu[i].TargetOriginInSource(), Eigen::Vector3d::Ones()});
    photos.push_back(i);
  }
  judged.in_first_block = static_cast<int>(pairs.size());
  const auto fitted = FitSimilarity3(pairs);
  if (!fitted) return judged;
  for (const std::size_t i : photos) {
    const geo::Rigid3 moved = fitted->Moved(found.cam_from_world[i]);
    judged.worst_center_m =
        std::max(judged.worst_center_m,
                 (moved.TargetOriginInSource() - scene.cam_from_enu[i].TargetOriginInSource()).norm());
    judged.worst_turn_rad =
        std::max(judged.worst_turn_rad, moved.rotation.angularDistance(scene.cam_from_enu[i].rotation));
  }
  return judged;
}

Registration Register(const Registration& input, int threads = 2) {
  SilentProgress progress;
  return RegisterPhotos(input, threads, progress);
}

void ExpectAllRight(const SyntheticOptions& options, double max_off_m, double focal_factor = 1.0) {
  const SyntheticScene scene = MakeScene(options);
  const Judged judged = Judge(scene, Register(InputOf(scene, focal_factor)));
  EXPECT_EQ(judged.in_first_block, options.columns * options.rows);
  EXPECT_LT(judged.worst_center_m, max_off_m);
  EXPECT_LT(judged.worst_turn_rad, 0.03);
}

TEST(RegisterPhotos, ALevelFlightWithoutAnyRecord) { ExpectAllRight({}, 0.5); }

TEST(RegisterPhotos, ObliquePhotosTurnedAllWays) { ExpectAllRight({.tilt_rad = 0.3, .any_yaw = true}, 0.7); }

TEST(RegisterPhotos, AClimbByFiveTimes) {
  ExpectAllRight({.columns = 30, .rows = 1, .step_m = 4.0, .climb_from_share = 0.2, .points_per_m2 = 1.0},
                 1.0);
}

// Across the gap no point is seen by three photos: what two show alike is projected to the ground.
TEST(RegisterPhotos, ALineWithAGapThatOnlyTwoPhotosLookAcross) {
  SyntheticScene scene = MakeScene({.columns = 10, .rows = 1, .step_m = 13.0, .relief_m = 1.0});
  scene.cam_from_enu.erase(scene.cam_from_enu.begin() + 4, scene.cam_from_enu.begin() + 6);
  scene.features.erase(scene.features.begin() + 4, scene.features.begin() + 6);
  const Judged judged = Judge(scene, Register(InputOf(scene)));
  EXPECT_EQ(judged.in_first_block, 8);
  EXPECT_LT(judged.worst_center_m, 5.0);
  EXPECT_LT(judged.worst_turn_rad, 0.1);
}

TEST(RegisterPhotos, AFocalLengthThatIsTenPercentOffIsCorrected) {
  SyntheticOptions options{.relief_m = 6.0, .tilt_rad = 0.3, .any_yaw = true};
  const SyntheticScene scene = MakeScene(options);
  const Registration found = Register(InputOf(scene, 1.1));
  EXPECT_EQ(Judge(scene, found).in_first_block, options.columns * options.rows);
  EXPECT_NEAR(found.lenses[0].intrinsics.MeanFocalPx(), scene.lens.MeanFocalPx(),
              0.015 * scene.lens.MeanFocalPx());
}

TEST(RegisterPhotos, TwoPlacesAreTwoBlocks) {
  SyntheticOptions options{.columns = 5, .rows = 2};
  const SyntheticScene here = MakeScene(options);
  options.columns = 4;
  options.seed = 2;
  const SyntheticScene there = MakeScene(options);
  Registration input = InputOf(here);
  for (const PhotoFeatures& features : there.features) input.Add(&features, 0, {});
  const Registration found = Register(input);
  ASSERT_EQ(found.block_sizes, (std::vector<int>{10, 8}));
  for (std::size_t i = 0; i < input.Photos(); ++i) EXPECT_EQ(found.block_of[i], i < 10 ? 0 : 1) << i;
}

// Of two cameras above two places: nothing in the larger block says anything of the other lens.
TEST(RegisterPhotos, EachLensIsFoundByTheBlockThatHasItsPhotos) {
  SyntheticOptions options{.relief_m = 6.0, .tilt_rad = 0.3, .any_yaw = true};
  const SyntheticScene here = MakeScene(options);
  options.columns = 5;
  options.points_per_m2 = 0.25;  // the block that is begun later
  options.seed = 2;
  const SyntheticScene there = MakeScene(options);
  Registration input = InputOf(here);
  input.lenses.push_back(InputOf(there, 1.1).lenses.front());
  for (const PhotoFeatures& features : there.features) input.Add(&features, 1, {});
  const Registration found = Register(input);
  ASSERT_GE(found.block_sizes.size(), 2U);
  EXPECT_EQ(found.LargestSize(), 24);
  EXPECT_EQ(found.block_of.front(), 0);
  EXPECT_GE(found.block_sizes[1], 10);
  const double focal_px = here.lens.MeanFocalPx();
  EXPECT_NEAR(found.lenses[0].intrinsics.MeanFocalPx(), focal_px, 0.015 * focal_px);
  EXPECT_NEAR(found.lenses[1].intrinsics.MeanFocalPx(), focal_px, 0.05 * focal_px);
}

struct CountedGroup {
  int photos = 0;
  int size() const { return photos; }
};

// Those of even size fit to each other, the others to none.
TEST(JoinGroups, AsksNoTwoAgainThatDidNotFit) {
  std::vector<CountedGroup> groups{{10}, {95}, {40}, {97}, {101}, {20}, {99}};
  std::map<std::pair<int, int>, int> asked;
  JoinGroups(
      [&asked](const CountedGroup& smaller, CountedGroup& larger) {
        ++asked[{larger.photos, smaller.photos}];
        if (larger.photos % 2 != 0 || smaller.photos % 2 != 0) return false;
        larger.photos += smaller.photos;
        return true;
      },
      groups);
  std::vector<int> sizes;
  for (const CountedGroup& group : groups) sizes.push_back(group.size());
  EXPECT_EQ(sizes, (std::vector<int>{101, 99, 97, 95, 70}));
  EXPECT_TRUE(asked.contains({101, 70})) << "one that has grown may fit now";
  for (const auto& [pair, times] : asked) EXPECT_EQ(times, 1) << pair.first << " and " << pair.second;
}

struct ListedGroup {
  std::vector<int> photos;
  bool Has(std::size_t photo) const {
    return std::find(photos.begin(), photos.end(), static_cast<int>(photo)) != photos.end();
  }
  int size() const { return static_cast<int>(photos.size()); }
};

// The first three photos that are neither used nor spent.
std::optional<ListedGroup> FirstThree(const PhotoSet& used, const PhotoSet& spent) {
  ListedGroup group;
  for (int i = 0; i < static_cast<int>(used.Photos()) && group.size() < 3; ++i) {
    if (!used.Has(i) && !spent.Has(i)) group.photos.push_back(i);
  }
  if (group.size() < 3) return std::nullopt;
  return group;
}

TEST(GrowGroups, GoesOnAfterOneThatFallsApart) {
  const std::vector<ListedGroup> groups =
      GrowGroups(12, &FirstThree, [](const PhotoSet& used, ListedGroup& group) {
        const int first = group.photos.front();
        if (first % 6 == 0) {
          group.photos.clear();
        } else if (first == 3 && !used.Has(1)) {
          group.photos.push_back(1);  // of one that fell apart
        }
      });
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].photos, (std::vector<int>{3, 4, 5, 1}));
  EXPECT_EQ(groups[1].photos, (std::vector<int>{9, 10, 11}));
}

TEST(GrowGroups, EndsWhereAllFallApart) {
  int grown = 0;
  const auto fall_apart = [&grown](const PhotoSet&, ListedGroup& group) {
    ++grown;
    group.photos.clear();
  };
  EXPECT_TRUE(GrowGroups(3000, &FirstThree, fall_apart).empty());
  EXPECT_EQ(grown, kMaxFallenApart);
  grown = 0;
  const auto always_the_same = [](const PhotoSet&, const PhotoSet&) {
    return std::optional(ListedGroup{{0, 1, 2}});
  };
  EXPECT_TRUE(GrowGroups(3000, always_the_same, fall_apart).empty());
  EXPECT_EQ(grown, 2);
}

// The larger block is the map where nothing says how two lie to each other, and may have lost photos last.
TEST(Registration, NumbersBlocksByTheirSizeInTheEnd) {
  Registration registration;
  registration.block_of = {0, 0, -1, 1, 1, 1, 2, 2};
  registration.block_sizes = {2, 3, 2};
  registration.NumberBySize();
  EXPECT_EQ(registration.block_of, (std::vector<int>{1, 1, -1, 0, 0, 0, 2, 2}));
  EXPECT_EQ(registration.block_sizes, (std::vector<int>{3, 2, 2}));
  EXPECT_EQ(registration.LargestSize(), 3);
}

TEST(RegisterPhotos, TheSameForAnyNumberOfThreads) {
  const SyntheticScene scene = MakeScene({.columns = 4, .rows = 2});
  const Registration one = Register(InputOf(scene), 1), three = Register(InputOf(scene), 3);
  ASSERT_EQ(one.Photos(), three.Photos());
  for (std::size_t i = 0; i < one.Photos(); ++i) {
    EXPECT_EQ(one.cam_from_world[i].translation, three.cam_from_world[i].translation);
    EXPECT_EQ(one.cam_from_world[i].rotation.coeffs(), three.cam_from_world[i].rotation.coeffs());
  }
}

TEST(RegisterPhotos, NothingComesOfNothing) {
  EXPECT_TRUE(Register({}).block_sizes.empty());
  Registration input;
  input.lenses.resize(1);
  input.lenses[0].recorded = input.lenses[0].intrinsics = camera::Intrinsics::Centered(400, 300, 300.0);
  for (int i = 0; i < 3; ++i) input.Add(nullptr, 0, {});
  EXPECT_TRUE(Register(input).block_sizes.empty());
}

}  // namespace
}  // namespace skyquilt::alignment
