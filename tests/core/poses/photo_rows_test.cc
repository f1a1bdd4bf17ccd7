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

// As archives and `upload` bring two cards to a server, which takes no folders.
TEST(NamedPhotos, TellsTwoCardsApartByFoldersJoinedToTheirNames) {
  const NamedPhotos named = Named({"100MEDIA_DJI_0001.JPG", "101MEDIA_DJI_0001.JPG", "DJI_0002.JPG"});
  EXPECT_THAT(named.Find("DCIM/101MEDIA/DJI_0001.JPG").photos, ElementsAre(1));
  EXPECT_THAT(named.Find("100MEDIA/DJI_0001").photos, ElementsAre(0));
  EXPECT_THAT(named.Find("101MEDIA_DJI_0001.JPG").photos, ElementsAre(1));
  for (const char* row : {"DJI_0001.JPG", "102MEDIA/DJI_0001.JPG"}) {
    EXPECT_THAT(named.Find(row).photos, IsEmpty()) << row;
    EXPECT_TRUE(named.Find(row).is_open) << row;
  }
  EXPECT_FALSE(named.Find("0001").is_open) << "no camera calls its photos so";
  for (const char* list : {"101MEDIA_positions.csv", "101MEDIA/positions.csv"}) {
    const auto found = named.FindAll(list, {"DJI_0001.JPG", "DJI_0002.JPG"});
    EXPECT_THAT(found[0].photos, ElementsAre(1)) << list;
    EXPECT_THAT(found[1].photos, ElementsAre(2)) << list;
  }
}

TEST(NamedPhotos, TakesTheFolderOfTheListWhereTheRowsHaveNone) {
  const NamedPhotos named = Named({"100MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0001.JPG"});
  EXPECT_THAT(named.FindAll("101MEDIA/positions.csv", {"DJI_0001.JPG"})[0].photos, ElementsAre(1));
  EXPECT_TRUE(named.FindAll("cards/positions.csv", {"DJI_0001.JPG"})[0].is_open);
}

// The first card came before the second and has its plain names.
TEST(NamedPhotos, TakesNoPhotoThatHasADoubleForTheOneOfThePlainName) {
  for (const char* double_name : {"101MEDIA_DJI_0001.JPG", "DJI_0001(2).JPG", "DJI_0001 (2).JPG"}) {
    const NamedPhotos named = Named({"DJI_0001.JPG", double_name, "DJI_0002.JPG"});
    EXPECT_TRUE(named.Find("DJI_0001.JPG").is_open) << double_name;
    EXPECT_TRUE(named.Find("100MEDIA/DJI_0001.JPG").is_open) << double_name;
    EXPECT_THAT(named.Find(double_name).photos, ElementsAre(1));
    EXPECT_THAT(named.Find("DJI_0002.JPG").photos, ElementsAre(2));
    const auto found = named.FindAll("101MEDIA_geo.txt", {"DJI_0001.JPG", double_name});
    EXPECT_THAT(found[0].photos, ElementsAre(0)) << "a list that calls the double so calls all by full names";
    EXPECT_THAT(found[1].photos, ElementsAre(1)) << double_name;
  }
  EXPECT_THAT(Named({"DJI_0001.JPG", "101MEDIA_DJI_0001.JPG"}).Find("101MEDIA/DJI_0001.JPG").photos,
              ElementsAre(1));
}

TEST(NamedPhotos, FindsLettersWithMarksInEitherForm) {
  EXPECT_THAT(Named({"Gr\u00fcn_1.JPG"}).Find("gru\u0308n_1.jpg").photos, ElementsAre(0));
  EXPECT_THAT(Named({"U\u0308ber_1.JPG"}).Find("\u00dcber_1.JPG").photos, ElementsAre(0));
}

TEST(NamedPhotos, FindsACaptureByAnyOfItsNames) {
  std::vector<flight::Photo> photos(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string capture = "SIM_000" + std::to_string(k);
    photos[k].name = capture + "_2.tif";
    photos[k].other_names = {capture + "_1.tif", capture + "_5.tif", capture};
  }
  const NamedPhotos named(photos);
  for (const char* row : {"SIM_0001_1.tif", "sim_0001_2.TIF", "SIM_0001_5", "SIM_0001", "SIM_0001.tif"})
    EXPECT_THAT(named.Find(row).photos, ElementsAre(1)) << row;
  EXPECT_THAT(named.Find("SIM_0001_3.tif").photos, IsEmpty());
}

TEST(NamedPhotos, DoesNotCompareThousandsOfFoldersForEachRow) {
  std::vector<std::string> names;
  for (int k = 0; k < 5000; ++k) names.push_back(std::to_string(k) + "/IMG.JPG");
  EXPECT_TRUE(Named(names).Find("IMG.JPG").is_open);
}

}  // namespace
}  // namespace skyquilt::poses
