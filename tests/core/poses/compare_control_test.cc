// Surveyed points, held against the flight that they are of.
#include <algorithm>

#include "core/geo/crs/reference_system.h"
#include "tests/core/poses/listed_flight.h"

namespace skyquilt::poses {
namespace {

using flight::RemarkCode;

flight::GcpList Survey(const LatLon& place = kDuluth, const std::string& system = "EPSG:32615",
                       bool is_swapped = false) {
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

// The flight after the list was held against it, and the list as it then is: without points if it is refused.
struct Held {
  Flight flight;
  flight::GcpList list;

  explicit Held(flight::GcpList survey, Flight flown = FlightAt(kDuluth)) : flight(std::move(flown)) {
    flight.gcp_lists = {std::move(survey)};
    EXPECT_TRUE(CompareSources(flight).ok());
    if (!flight.gcp_lists.empty()) list = flight.gcp_lists[0];
  }
  bool Says(RemarkCode code) const {
    return std::any_of(flight.warnings.begin(), flight.warnings.end(),
                       [&](const flight::Remark& said) { return said.code == code; });
  }
};

TEST(CompareControl, FindsThePhotosOfMarksAsItFindsThoseOfRows) {
  flight::GcpList survey = Survey();
  survey.sightings[0].image_name = "images/" + NameOf(0);
  survey.sightings[1].image_name = "C:\\flight\\dji_101.jpg";
  survey.sightings[2].image_name = "DCIM/100/DJI_102";
  const Held held(survey);
  ASSERT_EQ(held.list.sightings.size(), 5u);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(held.list.sightings[k].image_name, NameOf(k));
  EXPECT_TRUE(held.flight.warnings.empty());
}

TEST(CompareControl, SaysWhyMarksAreInNoPhoto) {
  flight::GcpList nobody = Survey(), some = Survey(), cards = Survey();
  for (flight::GcpSighting& mark : nobody.sightings) mark.image_name = "x" + mark.image_name;
  const Held of_nobody(nobody);
  EXPECT_TRUE(of_nobody.Says(RemarkCode::kListNamesNoPhoto));
  ASSERT_EQ(of_nobody.flight.gcp_lists.size(), 1u);
  EXPECT_TRUE(of_nobody.list.sightings.empty());
  some.sightings[3].image_name = "other.jpg";
  const Held of_some(some);
  EXPECT_TRUE(of_some.Says(RemarkCode::kMarksNameNoPhoto));
  EXPECT_EQ(of_some.list.sightings.size(), 4u);
  Flight flown = FlightAt(kDuluth);
  for (int k = 0; k < 18; ++k) flown.photos[k].name = (k < 9 ? "A/" : "B/") + NameOf(k % 9);
  cards.sightings[2].image_name = "B/" + NameOf(2);
  const Held of_cards(cards, flown);
  EXPECT_TRUE(of_cards.Says(RemarkCode::kListRowsOfSeveralPhotos));
  ASSERT_EQ(of_cards.list.sightings.size(), 1u);
  EXPECT_EQ(of_cards.list.sightings[0].image_name, "B/" + NameOf(2));
}

TEST(CompareControl, RefusesAListWhosePixelsLieOutsideItsPhotos) {
  Flight flown = FlightAt(kDuluth);
  for (flight::Photo& photo : flown.photos) photo.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  flight::GcpList survey = Survey();
  survey.sightings[1].pixel_y = 700.0;
  const Held typo(survey, flown);
  EXPECT_TRUE(typo.Says(RemarkCode::kMarksOutsidePhotos));
  EXPECT_EQ(typo.list.sightings.size(), 4u);
  survey.sightings[3].pixel_y = 700.0;
  const Held larger(survey, flown);
  EXPECT_TRUE(larger.flight.gcp_lists.empty());
  EXPECT_TRUE(larger.Says(RemarkCode::kControlOfOtherPixels));
  EXPECT_EQ(larger.flight.list_uses[0].fault, ListFault::kOtherPixels);
}

TEST(CompareControl, SaysWhatTheSystemOfASurveyIsKnownTo) {
  const LatLon milan{45.46, 9.19};
  flight::GcpList survey = Survey(kDuluth, "EPSG:3003");  // Monte Mario
  for (std::size_t k = 0; k < 5; ++k) {
    const flight::WrittenPlace at = In(3003)(Beside(milan, 30.0 * static_cast<double>(k), 0.0));
    survey.points[k].x = at.x;
    survey.points[k].y = at.y;
  }
  const Held held(survey, FlightAt(milan));
  EXPECT_GT(held.list.system_error_m.value_or(0.0), 1.0);
  EXPECT_THAT(InWords(held.flight.warnings), Contains(HasSubstr("older datum")));
}

TEST(CompareControl, JudgesSurveyedPointsByThePhotosThatShowThem) {
  for (const bool is_swapped : {false, true}) {
    const Held held(Survey(kDuluth, "EPSG:32615", is_swapped));
    ASSERT_EQ(held.list.points.size(), 5u);
    EXPECT_LT(geo::MetresApart(held.list.points[0].position, kDuluth), 0.5);
    EXPECT_EQ(held.flight.warnings.empty(), !is_swapped);
  }
  const Held unnamed(Survey(kDuluth, ""));
  EXPECT_TRUE(unnamed.flight.gcp_lists.empty());
  EXPECT_THAT(InWords(unnamed.flight.warnings), Contains(HasSubstr("EPSG:32615")));
  EXPECT_TRUE(Held(Survey(Beside(kDuluth, 0.0, 90'000.0))).flight.gcp_lists.empty()) << "elsewhere";
}

TEST(CompareControl, NamesMarksByThePhotosOfTheirFolders) {
  Flight flown = FlightAt(kDuluth);
  flown.photos[0].name = "100MEDIA_DJI_100.JPG";
  flown.photos[1].name = "101MEDIA_DJI_100.JPG";
  flight::GcpList survey = Survey();
  survey.sightings[1].image_name = "101MEDIA/DJI_100.JPG";
  const Held held(survey, flown);
  ASSERT_EQ(held.list.sightings.size(), 4u) << "of the first mark it is not told which photo it is in";
  EXPECT_EQ(held.list.sightings[0].image_name, "101MEDIA_DJI_100.JPG");
  EXPECT_THAT(InWords(held.flight.warnings), Contains(HasSubstr("of 1 row (DJI_100.JPG)")));
}

TEST(CompareControl, TakesOneOfTwoThatMarkTheSamePhotos) {
  Flight flown = FlightAt(kDuluth);
  flown.gcp_lists = {Survey(), Survey(), Survey()};
  flown.gcp_lists[1].file_name = "old_gcp_list.txt";
  flown.gcp_lists[2].file_name = "other_gcp_list.txt";
  flown.gcp_lists[2].points[1].x += 1.0;
  ASSERT_TRUE(CompareSources(flown).ok());
  ASSERT_EQ(flown.gcp_lists.size(), 2u);
  EXPECT_EQ(flown.gcp_lists[0].file_name, "gcp_list.txt");
  EXPECT_EQ(flown.gcp_lists[1].file_name, "other_gcp_list.txt");
  EXPECT_THAT(InWords(flown.warnings),
              Contains(HasSubstr("old_gcp_list.txt is not used: it is the same as gcp_list.txt")));
}

TEST(CompareControl, TakesOneOfTwoThatSayTheSameInOtherSystems) {
  for (const char* name : {"p0", "p0_check", "p0_of_more"}) {
    flight::GcpList metres = Survey(), degrees = Survey(kDuluth, "EPSG:4326");
    degrees.file_name = "wgs84.txt";
    for (std::size_t k = 0; k < 5; ++k) {
      const LatLon at = Beside(kDuluth, 30.0 * static_cast<double>(k), 20.0 * static_cast<double>(k % 2));
      for (flight::GcpList* const list : {&metres, &degrees}) {
        list->points[k].position = at;
        list->points[k].has_position = true;
      }
      degrees.points[k].x = at.lon_deg;
      degrees.points[k].y = at.lat_deg;
    }
    degrees.points[0].name = name;
    if (std::string(name) == "p0_of_more") degrees.points.push_back(degrees.points[4]);  // not marked yet
    std::reverse(degrees.sightings.begin(), degrees.sightings.end());
    Flight flown = FlightAt(kDuluth);
    flown.gcp_lists = {metres, degrees};
    ASSERT_TRUE(CompareSources(flown).ok());
    const bool are_same = std::string(name) == "p0";
    EXPECT_EQ(flown.gcp_lists.size(), are_same ? 1u : 2u) << name;
    if (are_same) {
      EXPECT_THAT(InWords(flown.warnings),
                  Contains(HasSubstr("wgs84.txt is not used: it is the same as gcp_list.txt")));
    }
  }
}

// Of two cards, beside the photos of one of which the list lies too: only there it is told which are meant.
TEST(CompareControl, TakesBothOfTwoThatMarkThePhotosOfTheirFolders) {
  Flight flown = FlightAt(kDuluth);
  for (int k = 0; k < 18; ++k) flown.photos[k].name = (k < 9 ? "A_" : "B_") + NameOf(k % 9);
  flown.gcp_lists = {Survey(), Survey()};
  flown.gcp_lists[1].file_name = "B_gcp_list.txt";
  ASSERT_TRUE(CompareSources(flown).ok());
  ASSERT_EQ(flown.gcp_lists.size(), 2u);
  EXPECT_TRUE(flown.gcp_lists[0].sightings.empty());
  ASSERT_EQ(flown.gcp_lists[1].sightings.size(), 5u);
  EXPECT_EQ(flown.gcp_lists[1].sightings[2].image_name, "B_" + NameOf(2));
}

}  // namespace
}  // namespace skyquilt::poses
