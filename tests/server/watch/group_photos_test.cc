#include <gtest/gtest.h>

#include "server/watch/card_flights.h"

namespace skyquilt::server {
namespace {

using namespace std::chrono_literals;

constexpr flight::UtcTime kMorning = std::chrono::sys_days(std::chrono::year(2026) / 5 / 7) + 8h;
constexpr auto kGap = 30min;

CardPhoto At(const char* path, std::chrono::minutes after, const char* camera = "DJI|M3E|A1") {
  return {path, camera, kMorning + after};
}

// The paths of each group, without their folders.
std::vector<std::string> Grouped(const std::vector<CardPhoto>& photos) {
  std::vector<std::string> groups;
  for (const std::vector<std::size_t>& group : GroupPhotos(photos, kGap)) {
    std::string names;
    for (const std::size_t index : group) names += photos[index].path.stem().string() + " ";
    groups.push_back(names);
  }
  return groups;
}

using Groups = std::vector<std::string>;

TEST(GroupPhotosTest, NothingIsNoFlight) { EXPECT_TRUE(GroupPhotos({}, kGap).empty()); }

TEST(GroupPhotosTest, APauseLongerThanTheGapParts) {
  EXPECT_EQ(Grouped({At("DCIM/100MEDIA/3.JPG", 60min), At("DCIM/100MEDIA/1.JPG", 0min),
                     At("DCIM/100MEDIA/2.JPG", 30min), At("DCIM/100MEDIA/4.JPG", 91min)}),
            (Groups{"1 2 3 ", "4 "}));
}

TEST(GroupPhotosTest, NumberedFoldersAreOneRollAndOthersAreNot) {
  EXPECT_EQ(Grouped({At("DCIM/100MEDIA/999.JPG", 0min), At("DCIM/101MEDIA/1.JPG", 1min)}),
            (Groups{"999 1 "}));
  EXPECT_EQ(Grouped({At("DCIM/field_a/1.JPG", 0min), At("DCIM/field_b/2.JPG", 1min)}), (Groups{"1 ", "2 "}));
  EXPECT_EQ(Grouped({At("a/100MEDIA/1.JPG", 0min), At("b/101MEDIA/2.JPG", 1min)}), (Groups{"1 ", "2 "}));
}

TEST(GroupPhotosTest, AnotherCameraIsAnotherFlight) {
  EXPECT_EQ(Grouped({At("d/1.JPG", 0min), At("d/2.JPG", 1min, "DJI|M3E|B2"), At("d/3.JPG", 2min)}),
            (Groups{"1 3 ", "2 "}));
}

TEST(GroupPhotosTest, APhotoWithoutATimeGoesWithTheOneBefore) {
  std::vector<CardPhoto> photos{At("d/1.JPG", 0min), At("d/2.JPG", 0min), At("d/3.JPG", 90min),
                                At("d/4.JPG", 0min)};
  photos[1].taken_at.reset();
  photos[3].taken_at.reset();
  EXPECT_EQ(Grouped(photos), (Groups{"1 2 ", "3 4 "}));
  photos[0].taken_at.reset();
  photos[1].taken_at = kMorning;
  EXPECT_EQ(Grouped(photos), (Groups{"1 2 ", "3 4 "}));
  for (CardPhoto& photo : photos) photo.taken_at.reset();
  EXPECT_EQ(Grouped(photos), (Groups{"1 2 3 4 "}));
}

TEST(GroupPhotosTest, KnowsFoldersWhoseNamesSayNothing) {
  for (const char* name : {"DCIM", "images", "100MEDIA", "101_PANO", "999CANON"})
    EXPECT_TRUE(SaysNothing(std::filesystem::path("card") / name)) << name;
  for (const char* name : {"DJI_202605070800_001_field", "100", "MEDIA100", "1000MEDIA"})
    EXPECT_FALSE(SaysNothing(std::filesystem::path("card") / name)) << name;
  EXPECT_EQ(RollOf("DCIM/104MEDIA/DJI_0001.JPG"), "DCIM/***MEDIA");
}

}  // namespace
}  // namespace skyquilt::server
