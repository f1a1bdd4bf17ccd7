// What a list's positions become on photos.
#include "core/poses/photo_rows.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {
namespace {

using ::testing::ElementsAre;

// A list of one row, and where it puts the photo.
flight::RecordedPosition TakenFromList(const std::optional<Eigen::Vector3d>& sigma_in_ned_m, bool is_fixed,
                                       flight::Photo photo = {}) {
  flight::FlightLog list;
  flight::CameraEvent& row = list.events.emplace_back();
  row.has_time = false;
  row.image_name = photo.name = "a.jpg";
  row.position = geo::LatLon{46.84, -91.99};
  row.sigma_in_ned_m = sigma_in_ned_m;
  row.is_rtk_fixed = is_fixed;
  std::vector<flight::Photo> photos{std::move(photo)};
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
  // Of a receiver, of a height alone, a program's default, and what nobody measured.
  for (const Eigen::Vector3d& sigma_in_ned_m :
       {Eigen::Vector3d(1.5, 1.5, 3.0), Eigen::Vector3d(0.05, 0.05, 3.0), Eigen::Vector3d(0.0, 0.0, 0.0),
        Eigen::Vector3d(1e-9, 1e-9, 1e-300)})
    EXPECT_FALSE(TakenFromList(sigma_in_ned_m, false).is_rtk_fixed) << sigma_in_ned_m.transpose();
}

TEST(PhotoRows, KeepTheHeightOfAPhotoThatHadNoPosition) {
  flight::Photo photo;
  photo.lone_height_above_takeoff_m = 39.8;
  EXPECT_EQ(TakenFromList({}, false, photo).height_above_takeoff_m, 39.8);
}

TEST(PhotoRows, LeavePhotosTheHeightsOfWhichTheirListSaysNothing) {
  std::vector<flight::Photo> photos(2);
  flight::FlightLog list;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    photos[k].name = k == 0 ? "a.jpg" : "b.jpg";
    flight::RecordedPosition& own = photos[k].position.emplace();
    own.position = {46.84, -91.99};
    own.height_amsl_m = 512.0;
    own.height_ellipsoid_m = 480.0;
    flight::CameraEvent& row = list.events.emplace_back();
    row.has_time = false;
    row.image_name = photos[k].name;
    row.position = geo::LatLon{46.8401, -91.99};
    row.is_rtk_fixed = k == 1;
  }
  const auto taken = [&] {
    std::vector<flight::Photo> now = photos;
    ApplyPhotoRows({list}, now);
    return now;
  };
  const auto of_places = taken();
  for (const flight::Photo& photo : of_places) {
    EXPECT_EQ(photo.position->position.lat_deg, 46.8401);
    EXPECT_EQ(photo.position->height_amsl_m, 512.0);
  }
  EXPECT_EQ(of_places[0].position->height_ellipsoid_m, 480.0);
  EXPECT_FALSE(of_places[1].position->height_ellipsoid_m) << "as if it were surveyed";
  // A receiver that counts from the ellipsoid alone, and one that was corrected itself.
  for (flight::Photo& photo : photos) photo.position->height_amsl_m.reset();
  EXPECT_NEAR(EllipsoidHeightM(*taken()[1].position).value_or(0.0), 480.0, 0.1);
  EXPECT_FALSE(taken()[1].position->height_ellipsoid_m);
  photos[1].position->is_rtk_fixed = true;
  EXPECT_EQ(taken()[1].position->height_ellipsoid_m, 480.0);
  // Where the list says some, two zeros would be mixed.
  list.events[0].height_ellipsoid_m = 490.0;
  const auto of_heights = taken();
  EXPECT_EQ(of_heights[0].position->height_ellipsoid_m, 490.0);
  EXPECT_FALSE(of_heights[0].position->height_amsl_m || of_heights[1].position->height_amsl_m);
}

// In feet, or above the take-off, under a name that says neither.
TEST(PhotoRows, SayHeightsThatContradictThoseOfThePhotos) {
  const auto warnings_of = [](double height_m, std::size_t count) {
    std::vector<flight::Photo> photos(count);
    flight::FlightLog list;
    for (std::size_t k = 0; k < photos.size(); ++k) {
      photos[k].name = std::to_string(k) + ".jpg";
      photos[k].position.emplace().position = {46.84, -91.99};
      photos[k].position->height_ellipsoid_m = 400.0;
      flight::CameraEvent& row = list.events.emplace_back();
      row.has_time = false;
      row.image_name = photos[k].name;
      row.position = geo::LatLon{46.84, -91.99};
      row.height_ellipsoid_m = height_m;
    }
    return ApplyPhotoRows({list}, photos).warnings;
  };
  for (const double height_m : {1312.3, 60.0}) {
    const std::vector<flight::Remark> said = warnings_of(height_m, 3);
    ASSERT_EQ(said.size(), 1U) << height_m;
    EXPECT_EQ(said.front().code, flight::RemarkCode::kListHeightsContradict);
    EXPECT_EQ(said.front().values.at("apart_m"), flight::RemarkValue(std::abs(height_m - 400.0)));
  }
  EXPECT_TRUE(warnings_of(350.0, 3).empty()) << "a barometer, or the geoid";
  EXPECT_TRUE(warnings_of(60.0, 2).empty()) << "one may be wrong by itself";
}

// "height" of a site by the sea, above the ellipsoid, is read as above the take-off.
TEST(PhotoRows, SayHeightsAboveTheTakeoffThatContradictThoseOfThePhotos) {
  const auto warnings_of = [](double list_m, double own_m, bool has_position) {
    std::vector<flight::Photo> photos(3);
    flight::FlightLog list;
    for (std::size_t k = 0; k < photos.size(); ++k) {
      photos[k].name = std::to_string(k) + ".jpg";
      if (has_position)
        photos[k].position.emplace().height_above_takeoff_m = own_m;
      else
        photos[k].lone_height_above_takeoff_m = own_m;
      flight::CameraEvent& row = list.events.emplace_back();
      row.has_time = false;
      row.image_name = photos[k].name;
      row.position = geo::LatLon{46.84, -91.99};
      row.height_above_takeoff_m = list_m;
    }
    return ApplyPhotoRows({list}, photos).warnings;
  };
  for (const bool has_position : {true, false}) {
    const std::vector<flight::Remark> said = warnings_of(100.0, 40.0, has_position);
    ASSERT_EQ(said.size(), 1U) << has_position;
    EXPECT_EQ(said.front().code, flight::RemarkCode::kListTakeoffHeightsContradict);
    EXPECT_EQ(said.front().values.at("apart_m"), flight::RemarkValue(60.0));
  }
  EXPECT_TRUE(warnings_of(52.0, 40.0, true).empty()) << "another barometer";
  EXPECT_TRUE(warnings_of(60.0, 0.0, true).empty()) << "a field that is never filled";
}

NamedPhotos Named(const std::vector<std::string>& names) {
  std::vector<flight::Photo> photos;
  for (const std::string& name : names) photos.emplace_back().name = name;
  return NamedPhotos(photos);
}

// A row, each by itself, and the numbers of the photos that it means.
struct Row {
  const char* name;
  std::vector<std::size_t> photos;
  bool is_open = false;
};

void ExpectFound(const NamedPhotos& named, const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    const NamedPhotos::Found found = named.FindAll("", {row.name}).front();
    EXPECT_EQ(found.photos, row.photos) << row.name;
    EXPECT_EQ(found.is_open, row.is_open) << row.name;
  }
}

TEST(NamedPhotos, IgnoresCaseFoldersAndMissingEndings) {
  ExpectFound(Named({"DCIM/DJI_0001.JPG", "DJI_0002.jpg", "field.1_0003.JPG"}),
              {{"dji_0001.jpg", {0}},
               {"C:\\Flights\\May\\DJI_0001.JPG", {0}},
               {"DJI_0002", {1}},
               {"field.1_0003", {2}}});
}

TEST(NamedPhotos, TakesTheRawFileBesideThePhotoForIt) {
  ExpectFound(
      Named({"DSC00001.JPG", "DSC00002.JPG"}),
      {{"DSC00002.ARW", {1}}, {"DSC00003.ARW", {}}, {"DSC00002.1_0001", {}}});  // that is no ending of a file
}

TEST(NamedPhotos, FindsNothingThatIsNotThere) {
  for (const char* name : {"", ".", "/", ".jpg", "DJI_0001.JPG/", "DJI_00011.JPG", "DJI_000"})
    ExpectFound(Named({"DJI_0001.JPG"}), {{name, {}}});
  ExpectFound(Named({}), {{"DJI_0001.JPG", {}}});
}

TEST(NamedPhotos, TellsTwoCardsApartByTheirFolders) {
  ExpectFound(Named({"100MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0001.JPG", "101MEDIA/DJI_0002.JPG"}),
              {{"/home/me/DCIM/101media/dji_0001.jpg", {1}},
               {"100MEDIA\\DJI_0001", {0}},
               {"DJI_0001.JPG", {}, true},  // of one card, and it is not said which
               {"DJI_0002.JPG", {2}}});
}

TEST(NamedPhotos, GivesPicturesOfOneExposureTheSameRow) {
  ExpectFound(Named({"DJI_0001.JPG", "DJI_0001.TIF"}), {{"DJI_0001", {0, 1}}, {"DJI_0001.TIF", {1}}});
}

// As archives and `upload` bring two cards to a server, which takes no folders.
TEST(NamedPhotos, TellsTwoCardsApartByFoldersJoinedToTheirNames) {
  const NamedPhotos named = Named({"100MEDIA_DJI_0001.JPG", "101MEDIA_DJI_0001.JPG", "DJI_0002.JPG"});
  ExpectFound(named, {{"DCIM/101MEDIA/DJI_0001.JPG", {1}},
                      {"100MEDIA/DJI_0001", {0}},
                      {"101MEDIA_DJI_0001.JPG", {1}},
                      {"DJI_0001.JPG", {}, true},
                      {"102MEDIA/DJI_0001.JPG", {}, true},
                      {"0001", {}}});  // no camera calls its photos so
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
    ExpectFound(named, {{"DJI_0001.JPG", {}, true},
                        {"100MEDIA/DJI_0001.JPG", {}, true},
                        {double_name, {1}},
                        {"DJI_0002.JPG", {2}}});
    const auto found = named.FindAll("101MEDIA_geo.txt", {"DJI_0001.JPG", double_name});
    EXPECT_THAT(found[0].photos, ElementsAre(0)) << "a list that calls the double so calls all by full names";
    EXPECT_THAT(found[1].photos, ElementsAre(1)) << double_name;
  }
  ExpectFound(Named({"DJI_0001.JPG", "101MEDIA_DJI_0001.JPG"}), {{"101MEDIA/DJI_0001.JPG", {1}}});
}

TEST(NamedPhotos, FindsLettersWithMarksInEitherForm) {
  ExpectFound(Named({"Gr\u00fcn_1.JPG", "U\u0308ber_1.JPG"}),
              {{"gru\u0308n_1.jpg", {0}}, {"\u00dcber_1.JPG", {1}}});
}

TEST(NamedPhotos, FindsACaptureByAnyOfItsNames) {
  std::vector<flight::Photo> photos(2);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string capture = "SIM_000" + std::to_string(k);
    photos[k].name = capture + "_2.tif";
    photos[k].other_names = {capture + "_1.tif", capture + "_5.tif", capture};
  }
  for (const char* row : {"SIM_0001_1.tif", "sim_0001_2.TIF", "SIM_0001_5", "SIM_0001", "SIM_0001.tif"})
    ExpectFound(NamedPhotos(photos), {{row, {1}}});
  ExpectFound(NamedPhotos(photos), {{"SIM_0001_3.tif", {}}});
}

TEST(NamedPhotos, DoesNotCompareThousandsOfFoldersForEachRow) {
  std::vector<std::string> names;
  for (int k = 0; k < 5000; ++k) names.push_back(std::to_string(k) + "/IMG.JPG");
  ExpectFound(Named(names), {{"IMG.JPG", {}, true}});
}

}  // namespace
}  // namespace skyquilt::poses
