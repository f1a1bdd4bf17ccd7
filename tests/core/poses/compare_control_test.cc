// Surveyed points, held against the flight that they are of.
#include <algorithm>

#include "core/geo/crs/reference_system.h"
#include "core/poses/lists/judge_list.h"
#include "tests/core/poses/listed_flight.h"

namespace skyquilt::poses {
namespace {

flight::GcpList Survey(const LatLon& place, const std::string& system, bool is_swapped) {
  flight::GcpList list;
  list.file_name = "gcp_list.txt";
  list.reference_system = system;
  for (int k = 0; k < 5; ++k) {
    const flight::WrittenPlace at = In(32615)(Beside(place, 30.0 * k, 20.0 * (k % 2)));
    flight::GcpPoint point;
    point.name = "p" + std::to_string(k);
    point.x = is_swapped ? at.y : at.x;
    point.y = is_swapped ? at.x : at.y;
    point.has_position = false;
    list.points.push_back(point);
    list.sightings.push_back({NameOf(k), 100.0, 100.0, static_cast<std::size_t>(k)});
  }
  return list;
}

bool IsSaid(const Flight& flight, flight::RemarkCode code) {
  return std::any_of(flight.warnings.begin(), flight.warnings.end(),
                     [&](const flight::Remark& said) { return said.code == code; });
}

TEST(CompareControl, FindsThePhotosOfMarksAsItFindsThoseOfRows) {
  Flight flight = FlightAt(kDuluth);
  flight.gcp_lists = {Survey(kDuluth, "EPSG:32615", false)};
  std::vector<flight::GcpSighting>& marks = flight.gcp_lists[0].sightings;
  marks[0].image_name = "images/" + NameOf(0);
  marks[1].image_name = "C:\\flight\\dji_101.jpg";
  marks[2].image_name = "DCIM/100/DJI_102";
  ASSERT_TRUE(CompareSources(flight).ok());
  ASSERT_EQ(flight.gcp_lists.size(), 1u);
  ASSERT_EQ(flight.gcp_lists[0].sightings.size(), 5u);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(flight.gcp_lists[0].sightings[k].image_name, NameOf(k));
  EXPECT_TRUE(flight.warnings.empty());
}

TEST(CompareControl, SaysWhyMarksAreInNoPhoto) {
  Flight nobody = FlightAt(kDuluth);
  nobody.gcp_lists = {Survey(kDuluth, "EPSG:32615", false)};
  Flight some = nobody;
  for (flight::GcpSighting& mark : nobody.gcp_lists[0].sightings) mark.image_name = "x" + mark.image_name;
  ASSERT_TRUE(CompareSources(nobody).ok());
  EXPECT_TRUE(IsSaid(nobody, flight::RemarkCode::kListNamesNoPhoto));
  EXPECT_TRUE(nobody.gcp_lists[0].sightings.empty());
  some.gcp_lists[0].sightings[3].image_name = "other.jpg";
  ASSERT_TRUE(CompareSources(some).ok());
  EXPECT_TRUE(IsSaid(some, flight::RemarkCode::kMarksNameNoPhoto));
  EXPECT_EQ(some.gcp_lists[0].sightings.size(), 4u);

  Flight cards = FlightAt(kDuluth);
  for (int k = 0; k < 18; ++k) cards.photos[k].name = (k < 9 ? "A/" : "B/") + NameOf(k % 9);
  cards.gcp_lists = {Survey(kDuluth, "EPSG:32615", false)};
  cards.gcp_lists[0].sightings[2].image_name = "B/" + NameOf(2);
  ASSERT_TRUE(CompareSources(cards).ok());
  EXPECT_TRUE(IsSaid(cards, flight::RemarkCode::kListRowsOfSeveralPhotos));
  ASSERT_EQ(cards.gcp_lists[0].sightings.size(), 1u);
  EXPECT_EQ(cards.gcp_lists[0].sightings[0].image_name, "B/" + NameOf(2));
}

TEST(CompareControl, RefusesAListWhosePixelsLieOutsideItsPhotos) {
  Flight flight = FlightAt(kDuluth);
  for (flight::Photo& photo : flight.photos) photo.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  flight.gcp_lists = {Survey(kDuluth, "EPSG:32615", false)};
  Flight typo = flight;
  for (const std::size_t k : {1u, 3u}) flight.gcp_lists[0].sightings[k].pixel_y = 700.0;
  ASSERT_TRUE(CompareSources(flight).ok());
  EXPECT_TRUE(flight.gcp_lists.empty());
  EXPECT_TRUE(IsSaid(flight, flight::RemarkCode::kControlOfOtherPixels));
  EXPECT_EQ(flight.list_uses[0].fault, ListFault::kOtherPixels);
  typo.gcp_lists[0].sightings[1].pixel_y = 700.0;
  ASSERT_TRUE(CompareSources(typo).ok());
  EXPECT_TRUE(IsSaid(typo, flight::RemarkCode::kMarksOutsidePhotos));
  EXPECT_EQ(typo.gcp_lists[0].sightings.size(), 4u);
}

TEST(CompareControl, SaysWhatTheSystemOfASurveyIsKnownTo) {
  const LatLon milan{45.46, 9.19};
  Flight flight = FlightAt(milan);
  flight.gcp_lists = {Survey(kDuluth, "EPSG:3003", false)};  // Monte Mario
  for (std::size_t k = 0; k < 5; ++k) {
    const flight::WrittenPlace at = In(3003)(Beside(milan, 30.0 * static_cast<double>(k), 0.0));
    flight.gcp_lists[0].points[k].x = at.x;
    flight.gcp_lists[0].points[k].y = at.y;
  }
  ASSERT_TRUE(CompareSources(flight).ok());
  ASSERT_EQ(flight.gcp_lists.size(), 1u);
  EXPECT_GT(flight.gcp_lists[0].system_error_m.value_or(0.0), 1.0);
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("older datum")));
}

TEST(CompareControl, JudgesSurveyedPointsByThePhotosThatShowThem) {
  for (const bool is_swapped : {false, true}) {
    Flight flight = FlightAt(kDuluth);
    flight.gcp_lists = {Survey(kDuluth, "EPSG:32615", is_swapped)};
    ASSERT_TRUE(CompareSources(flight).ok());
    ASSERT_EQ(flight.gcp_lists.size(), 1u);
    ASSERT_EQ(flight.gcp_lists[0].points.size(), 5u);
    EXPECT_LT(geo::MetresApart(flight.gcp_lists[0].points[0].position, kDuluth), 0.5);
    EXPECT_EQ(flight.warnings.empty(), !is_swapped);
  }
  Flight unnamed = FlightAt(kDuluth);
  unnamed.gcp_lists = {Survey(kDuluth, "", false)};
  ASSERT_TRUE(CompareSources(unnamed).ok());
  EXPECT_TRUE(unnamed.gcp_lists.empty());
  EXPECT_THAT(InWords(unnamed.warnings), Contains(HasSubstr("EPSG:32615")));
  Flight elsewhere = FlightAt(kDuluth);
  elsewhere.gcp_lists = {Survey(Beside(kDuluth, 0.0, 90'000.0), "EPSG:32615", false)};
  ASSERT_TRUE(CompareSources(elsewhere).ok());
  EXPECT_TRUE(elsewhere.gcp_lists.empty());
}

TEST(CompareControl, NamesMarksByThePhotosOfTheirFolders) {
  Flight flight = FlightAt(kDuluth);
  flight.photos[0].name = "100MEDIA_DJI_100.JPG";
  flight.photos[1].name = "101MEDIA_DJI_100.JPG";
  flight.gcp_lists = {Survey(kDuluth, "EPSG:32615", false)};
  std::vector<flight::GcpSighting>& marks = flight.gcp_lists[0].sightings;
  marks[1].image_name = "101MEDIA/DJI_100.JPG";
  ASSERT_TRUE(CompareSources(flight).ok());
  ASSERT_EQ(flight.gcp_lists.size(), 1u);
  ASSERT_EQ(flight.gcp_lists[0].sightings.size(), 4u)
      << "of the first mark it is not told which photo it is in";
  EXPECT_EQ(flight.gcp_lists[0].sightings[0].image_name, "101MEDIA_DJI_100.JPG");
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("of 1 row (dji_100.jpg)")));
}

}  // namespace
}  // namespace skyquilt::poses
