#include "core/poses/lists/named_photos.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace skyquilt::poses {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

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
