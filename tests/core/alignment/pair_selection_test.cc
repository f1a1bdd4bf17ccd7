// Which photos of one flight at two heights are compared.
#include "core/alignment/matching/pair_selection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/alignment/matching/best_partners.h"

namespace skyquilt::alignment {
namespace {

// Straight down, top of the image to the north.
View LooksDown(double east_m, double north_m, double height_m) {
  View view;
  view.intrinsics = camera::Intrinsics::Centered(640, 480, 480.0);
  view.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX())),
      {east_m, north_m, height_m});
  view.height_above_ground_m = height_m;
  return view;
}

// Six photos from above, then twenty of the middle of what they show.
std::vector<View> AtTwoHeights(double high_m, double low_m) {
  std::vector<View> views;
  for (const double east : {-0.23, 0.23}) {
    for (const double north : {-0.25, 0.0, 0.25})
      views.push_back(LooksDown(east * high_m, north * high_m, high_m));
  }
  for (int i = 0; i < 20; ++i)
    views.push_back(LooksDown(0.5 * low_m * (i % 4 - 1.5), 0.3 * low_m * (i / 4 - 2.0), low_m));
  return views;
}

constexpr int kHigh = 6;

std::vector<PhotoPair> Select(const std::vector<View>& views) {
  return SelectPairs(views, std::vector<double>(views.size(), 2.0), Relief(0.0));
}

int PairsWithin(const std::vector<PhotoPair>& pairs, int first, int end) {
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const PhotoPair& pair) {
    return pair.first >= first && pair.second < end;
  }));
}

int PairsAcross(const std::vector<PhotoPair>& pairs, int photo) {
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const PhotoPair& pair) {
    const bool is_across = pair.first < kHigh && pair.second >= kHigh;
    return is_across && (pair.first == photo || pair.second == photo);
  }));
}

TEST(SelectPairs, ComparesPhotosOfTheirOwnHeightWhateverTheySeeOfThoseBelow) {
  for (const double low_m : {8.0, 35.0}) {
    const std::vector<PhotoPair> pairs = Select(AtTwoHeights(120.0, low_m));
    EXPECT_GE(PairsWithin(pairs, 0, kHigh), 11) << low_m;
    EXPECT_GE(PairsWithin(pairs, kHigh, 26), 40) << low_m;
  }
}

TEST(SelectPairs, TiesBothHeightsWhereTheirFeaturesCanBeTheSame) {
  const std::vector<PhotoPair> near = Select(AtTwoHeights(120.0, 35.0));
  for (int i = 0; i < 26; ++i) EXPECT_GE(PairsAcross(near, i), 1) << i;
  const std::vector<PhotoPair> far = Select(AtTwoHeights(120.0, 8.0));
  for (int i = 0; i < 26; ++i) EXPECT_EQ(PairsAcross(far, i), 0) << i;
}

// A rig of bands and a camera in colour of more pixels, above the same ground.
TEST(SelectPairs, ComparesCamerasSideBySideAsOne) {
  std::vector<View> views;
  for (int i = 0; i < 12; ++i) {
    for (const int times : {1, 8}) {
      View view = LooksDown(20.0 * i, 0.0, 80.0);
      view.intrinsics = camera::Intrinsics::Centered(640 * times, 480 * times, 480.0 * times);
      views.push_back(view);
    }
  }
  const std::vector<PhotoPair> pairs = Select(views);
  for (int i = 0; i < 24; i += 2) {
    const auto across = std::count_if(pairs.begin(), pairs.end(), [&](const PhotoPair& pair) {
      return (pair.first == i && pair.second % 2 == 1) || (pair.second == i && pair.first % 2 == 1);
    });
    EXPECT_GE(across, 2) << i;
  }
}

// All photos of a flight that hovers may be compared with each other.
TEST(BestPartners, AreFewOfManyAndThoseThatSortingAllWouldChoose) {
  const auto direction_of = [](int photo) { return photo % 100 == 7 ? 5 : photo % 3; };
  BestPartners partners;
  int wanted = 0;
  std::vector<BestPartners::Partner> all;
  for (int photo = 0; photo < 1000; ++photo) {
    all.emplace_back(-((photo * 37) % 101) / 101.0, photo);
    const std::vector<BestPartners::Partner> before = partners.Chosen();
    const bool is_wanted = partners.Wants(all.back(), direction_of(photo));
    partners.Add(all.back(), direction_of(photo));
    EXPECT_EQ(is_wanted, partners.Chosen() != before) << photo;
    wanted += is_wanted ? 1 : 0;
  }
  EXPECT_LT(wanted, 150) << "of a thousand: most need no overlap counted";
  std::sort(all.begin(), all.end());
  std::vector<BestPartners::Partner> expected;
  std::array<bool, BestPartners::kDirections> served{};
  for (const BestPartners::Partner& one : all) {
    bool& is_served = served[direction_of(one.second)];
    if (expected.size() >= BestPartners::kBest && is_served) continue;
    is_served = true;
    expected.push_back(one);
  }
  EXPECT_EQ(partners.Chosen(), expected);
  EXPECT_LE(expected.size(), 14u);
  for (const BestPartners::Partner& one : all) {
    const BestPartners::Partner unlike(-2.0 - one.first, one.second);
    const std::vector<BestPartners::Partner> before = partners.Chosen();
    const bool is_wanted = partners.WantsUnlike(unlike);
    partners.AddUnlike(unlike);
    EXPECT_EQ(is_wanted, partners.Chosen() != before) << one.second;
  }
  EXPECT_EQ(partners.Chosen().size(), expected.size() + BestPartners::kBestOfUnlike);
}

}  // namespace
}  // namespace skyquilt::alignment
