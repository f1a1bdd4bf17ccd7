// What a list's positions become on photos.
#include "core/poses/photo_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

flight::RecordedPosition TakenFromList(const std::optional<Eigen::Vector3d>& sigma_in_ned_m, bool is_fixed) {
  flight::FlightLog list;
  list.file_name = "geo.txt";
  flight::CameraEvent& row = list.events.emplace_back();
  row.has_time = false;
  row.image_name = "a.jpg";
  row.position = geo::LatLon{46.84, -91.99};
  row.height_ellipsoid_m = 300.0;
  row.sigma_in_ned_m = sigma_in_ned_m;
  row.is_rtk_fixed = is_fixed;
  std::vector<flight::Photo> photos(1);
  photos[0].name = "a.jpg";
  ApplyPhotoRows({list}, photos);
  return photos[0].position.value_or(flight::RecordedPosition());
}

TEST(PhotoRows, ThatStateCentimetresAreOfCorrectedPositions) {
  const auto surveyed = TakenFromList(Eigen::Vector3d(0.02, 0.02, 0.04), false);
  EXPECT_TRUE(surveyed.is_rtk_fixed);
  EXPECT_DOUBLE_EQ(*surveyed.sigma_horizontal_m, 0.02);
  EXPECT_DOUBLE_EQ(*surveyed.sigma_vertical_m, 0.04);
  EXPECT_TRUE(TakenFromList(std::nullopt, true).is_rtk_fixed) << "the list says it in a word";
}

TEST(PhotoRows, ThatStateMoreOrNothingAreNot) {
  EXPECT_FALSE(TakenFromList(std::nullopt, false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(1.5, 1.5, 3.0), false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(0.05, 0.05, 3.0), false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(0.0, 0.0, 0.0), false).is_rtk_fixed) << "a program's default";
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(1e-9, 1e-9, 1e-300), false).is_rtk_fixed)
      << "nobody measured it";
}

TEST(PhotoRows, KeepTheHeightOfAPhotoThatHadNoPosition) {
  flight::FlightLog list;
  flight::CameraEvent& row = list.events.emplace_back();
  row.has_time = false;
  row.image_name = "a.jpg";
  row.position = geo::LatLon{46.84, -91.99};
  std::vector<flight::Photo> photos(1);
  photos[0].name = "a.jpg";
  photos[0].lone_height_above_takeoff_m = 39.8;
  ApplyPhotoRows({list}, photos);
  ASSERT_TRUE(photos[0].position);
  EXPECT_EQ(photos[0].position->height_above_takeoff_m, 39.8);
}

NamedPhotos Named(const std::vector<std::string>& names) {
  std::vector<flight::Photo> photos;
  for (const std::string& name : names) photos.emplace_back().name = name;
  return NamedPhotos(photos);
}

TEST(NamedPhotos, IgnoresCaseFoldersAndMissingEndings) {
  const NamedPhotos named = Named({"DCIM/DJI_0001.JPG", "DJI_0002.jpg", "field.1_0003.JPG"});
  EXPECT_THAT(named.Find("dji_0001.jpg").photos, ElementsAre(0));
  EXPECT_THAT(named.Find("C:\\Flights\\May\\DJI_0001.JPG").photos, ElementsAre(0));
  EXPECT_THAT(named.Find("DJI_0002").photos, ElementsAre(1));
  EXPECT_THAT(named.Find("field.1_0003").photos, ElementsAre(2));
}

TEST(NamedPhotos, TakesTheRawFileBesideThePhotoForIt) {
  const NamedPhotos named = Named({"DSC00001.JPG", "DSC00002.JPG"});
  EXPECT_THAT(named.Find("DSC00002.ARW").photos, ElementsAre(1));
  EXPECT_THAT(named.Find("DSC00003.ARW").photos, IsEmpty());
  EXPECT_THAT(named.Find("DSC00002.1_0001").photos, IsEmpty()) << "that is no ending of a file";
}

TEST(NamedPhotos, FindsNothingThatIsNotThere) {
  const NamedPhotos named = Named({"DJI_0001.JPG"});
  for (const char* name : {"", ".", "/", ".jpg", "DJI_0001.JPG/", "DJI_00011.JPG", "DJI_000"}) {
    EXPECT_THAT(named.Find(name).photos, IsEmpty()) << name;
    EXPECT_FALSE(named.Find(name).is_open) << name;
  }
  EXPECT_THAT(Named({}).Find("DJI_0001.JPG").photos, IsEmpty());
}

TEST(NamedPhotos, TellsTwoCardsApartByTheirFolders) {
  const NamedPhotos named =
      Named({"100MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0002.JPG"});
  EXPECT_THAT(named.Find("/home/me/DCIM/101media/dji_0001.jpg").photos, ElementsAre(1));
  EXPECT_THAT(named.Find("100MEDIA\\DJI_0001").photos, ElementsAre(0));
  EXPECT_THAT(named.Find("DJI_0001.JPG").photos, IsEmpty()) << "of one card, and it is not said which";
  EXPECT_TRUE(named.Find("DJI_0001.JPG").is_open);
  EXPECT_THAT(named.Find("DJI_0002.JPG").photos, ElementsAre(2));
}

TEST(NamedPhotos, GivesPicturesOfOneExposureTheSameRow) {
  const NamedPhotos named = Named({"DJI_0001.JPG", "DJI_0001.TIF"});
  EXPECT_THAT(named.Find("DJI_0001").photos, ElementsAre(0, 1));
  EXPECT_THAT(named.Find("DJI_0001.TIF").photos, ElementsAre(1));
}

TEST(NamedPhotos, DoesNotCompareThousandsOfFoldersForEachRow) {
  std::vector<std::string> names;
  for (int k = 0; k < 5000; ++k) names.push_back(std::to_string(k) + "/IMG.JPG");
  EXPECT_TRUE(Named(names).Find("IMG.JPG").is_open);
}

}  // namespace
}  // namespace skyquilt::poses
