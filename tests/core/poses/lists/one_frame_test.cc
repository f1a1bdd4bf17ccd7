// A list that names part of the photos: in which frame the others come to lie.
#include "core/poses/lists/one_frame.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <string>

#include "core/flight/remarks/remark_words.h"
#include "core/geo/local_frame.h"
#include "core/poses/estimate_poses.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector2d;
using flight::Photo;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr std::size_t kFlown = 12;
const geo::LocalFrame kTangent({47.4, 8.5, 0.0});

geo::LatLon PlaceAt(const Vector2d& at) {
  const geo::Wgs84 place = kTangent.Wgs84FromEnu({at.x(), at.y(), 0.0});
  return {place.lat_deg, place.lon_deg};
}

Vector2d MetresOf(const Photo& photo) {
  const geo::LatLon& place = photo.position->position;
  return kTangent.EnuFromWgs84({place.lat_deg, place.lon_deg, 0.0}).head<2>();
}

// Three lines of four, 25 m apart, half a metre off by the receiver.
Vector2d OwnAt(std::size_t k) {
  const double turn = 2.4 * static_cast<double>(k);
  return Vector2d(25.0 * static_cast<double>(k % 4), 25.0 * static_cast<double>(k / 4)) +
         0.5 * Vector2d(std::cos(turn), std::sin(turn));
}

std::vector<Photo> OwnPhotos() {
  std::vector<Photo> photos;
  for (std::size_t k = 0; k < kFlown; ++k) {
    Photo& photo = photos.emplace_back();
    photo.name = "IMG_" + std::to_string(100 + k) + ".JPG";
    photo.camera_key = "one";
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    photo.captured_at = flight::UtcTime(std::chrono::seconds(1'717'243'200 + 3 * k));
    photo.position.emplace().position = PlaceAt(OwnAt(k));
    photo.position->height_above_takeoff_m = 60.0;
    photo.position->height_ellipsoid_m = 510.0;
    photo.position->source = "exif";
  }
  return photos;
}

void Name(const Vector2d& off_m, double higher_m, Photo& photo) {
  photo.position->position = PlaceAt(MetresOf(photo) + off_m);
  *photo.position->height_ellipsoid_m += higher_m;
  photo.position->source = "geo.txt";
}

// The first photos as a list has them.
std::vector<Photo> Named(std::size_t count, const Vector2d& off_m, double higher_m = 0.0) {
  std::vector<Photo> photos = OwnPhotos();
  for (std::size_t k = 0; k < count; ++k) Name(off_m, higher_m, photos[k]);
  return photos;
}

void ExpectOff(const Photo& photo, std::size_t k, const Vector2d& off_m) {
  EXPECT_LT((MetresOf(photo) - OwnAt(k) - off_m).norm(), 0.2) << photo.name;
}

TEST(BringIntoOneFrame, MovesPhotosWithoutARowByTheShiftOfTheOthers) {
  std::vector<Photo> photos = Named(6, {15.0, -2.0}, 45.0);
  const OneFrame result = BringIntoOneFrame(OwnPhotos(), photos);
  for (std::size_t k = 0; k < kFlown; ++k) {
    ExpectOff(photos[k], k, {15.0, -2.0});
    EXPECT_NEAR(*photos[k].position->height_ellipsoid_m, 555.0, 0.01);
    EXPECT_EQ(*photos[k].position->height_above_takeoff_m, 60.0);
    EXPECT_FALSE(photos[k].position->sigma_horizontal_m);
  }
  EXPECT_FALSE(result.contradict_m);
  EXPECT_THAT(InWords(result.warnings), Contains(HasSubstr("this camera's others (6) are moved")));
  EXPECT_THAT(InWords(result.warnings), Contains(HasSubstr("its heights lie 45")));
}

TEST(BringIntoOneFrame, IsNotLedAstrayByAWrongRow) {
  std::vector<Photo> photos = Named(6, {15.0, 0.0});
  Name({300.0, 100.0}, 0.0, photos[2]);
  BringIntoOneFrame(OwnPhotos(), photos);
  for (std::size_t k = 6; k < kFlown; ++k) ExpectOff(photos[k], k, {15.0, 0.0});
}

TEST(BringIntoOneFrame, LearnsNoShiftFromOneOrTwoRows) {
  for (const std::size_t count : {1U, 2U}) {
    std::vector<Photo> photos = Named(count, {15.0, 0.0});
    const OneFrame result = BringIntoOneFrame(OwnPhotos(), photos);
    for (std::size_t k = count; k < kFlown; ++k) {
      ExpectOff(photos[k], k, {0.0, 0.0});
      EXPECT_NEAR(photos[k].position->sigma_horizontal_m.value_or(0.0), 15.0, 0.1);
    }
    EXPECT_FALSE(photos[0].position->sigma_horizontal_m);
    EXPECT_NEAR(result.contradict_m.value_or(0.0), 15.0, 0.1);
    EXPECT_THAT(InWords(result.warnings), Contains(HasSubstr("are held for no better than that")));
  }
}

TEST(BringIntoOneFrame, HoldsPhotosForNoBetterWhereRowsLieOffInEveryDirection) {
  std::vector<Photo> photos = OwnPhotos();
  for (std::size_t k = 0; k < 6; ++k) {
    const double turn = geo::kPi / 3.0 * static_cast<double>(k);
    Name(14.0 * Vector2d(std::cos(turn), std::sin(turn)), 0.0, photos[k]);
  }
  photos[8].position->is_rtk_fixed = true;
  const OneFrame result = BringIntoOneFrame(OwnPhotos(), photos);
  ExpectOff(photos[8], 8, {0.0, 0.0});
  EXPECT_NEAR(photos[8].position->sigma_horizontal_m.value_or(0.0), 14.0, 0.1);
  EXPECT_FALSE(photos[8].position->is_rtk_fixed);
  EXPECT_NEAR(result.contradict_m.value_or(0.0), 14.0, 0.1);
}

TEST(BringIntoOneFrame, MovesNoPhotosOfAnotherCamera) {
  std::vector<Photo> own = OwnPhotos(), photos = Named(6, {8.0, 0.0});
  for (std::size_t k = 9; k < kFlown; ++k) own[k].camera_key = photos[k].camera_key = "two";
  const OneFrame result = BringIntoOneFrame(own, photos);
  ExpectOff(photos[7], 7, {8.0, 0.0});
  ExpectOff(photos[10], 10, {0.0, 0.0});
  EXPECT_NEAR(photos[10].position->sigma_horizontal_m.value_or(0.0), 8.0, 0.1);
  EXPECT_FALSE(result.contradict_m) << "receivers err by as much";
}

TEST(BringIntoOneFrame, LeavesWhatAgreesAndWhatHasNoPlaceOfItsOwn) {
  std::vector<Photo> photos = Named(6, {0.1, 0.1});
  EXPECT_TRUE(BringIntoOneFrame(OwnPhotos(), photos).warnings.empty());
  ExpectOff(photos[9], 9, {0.0, 0.0});
  // A fix that all repeat.
  std::vector<Photo> stale = OwnPhotos();
  for (Photo& photo : stale) photo.position->position = PlaceAt({0.0, 0.0});
  std::vector<Photo> listed = stale;
  for (std::size_t k = 0; k < 6; ++k) {
    listed[k].position->position = PlaceAt(OwnAt(k));
    listed[k].position->source = "geo.txt";
  }
  EXPECT_TRUE(BringIntoOneFrame(stale, listed).warnings.empty());
  EXPECT_FALSE(listed[9].position->sigma_horizontal_m);
}

TEST(EstimatePoses, LaysPhotosWithAndWithoutARowInOneFrame) {
  flight::Flight flight;
  flight.photos = OwnPhotos();
  flight::FlightLog& list = flight.logs.emplace_back();
  list.format = "geo_txt";
  list.file_name = "geo.txt";
  for (std::size_t k = 0; k < kFlown; k += 2) {
    flight::CameraEvent& row = list.events.emplace_back();
    row.has_time = false;
    row.image_name = flight.photos[k].name;
    row.position = PlaceAt(OwnAt(k) + Vector2d(15.0, 0.0));
    row.height_ellipsoid_m = 510.0;
  }
  const auto posed = EstimatePoses(flight, {});
  ASSERT_TRUE(posed.ok()) << posed.error().message;
  ASSERT_EQ(posed->photos.size(), kFlown);
  for (std::size_t k = 0; k < kFlown; ++k) {
    EXPECT_EQ(posed->photos[k].photo.name, flight.photos[k].name);
    ExpectOff(posed->photos[k].photo, k, {15.0, 0.0});
  }
  EXPECT_THAT(InWords(posed->warnings), Contains(HasSubstr("lies 15.0 m from their own positions")));
}

}  // namespace
}  // namespace skyquilt::poses
