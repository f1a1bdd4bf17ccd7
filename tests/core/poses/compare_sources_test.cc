#include "core/poses/lists/compare_sources.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/geo/crs/map_projection.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/geodesic.h"
#include "core/poses/lists/judge_list.h"
#include "core/poses/lists/list_words.h"

namespace skyquilt::poses {
namespace {

using flight::CountsIn;
using flight::Flight;
using flight::FlightLog;
using flight::ListFault;
using geo::LatLon;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr LatLon kDuluth{46.8426, -91.9945};
constexpr LatLon kZurich{47.4, 8.5};
constexpr LatLon kSydney{-33.86, 151.21};
constexpr LatLon kLaPaz{-16.5, -68.15};

LatLon Beside(const LatLon& place, double east_m, double north_m) {
  const double lat_deg = place.lat_deg + north_m / 111'200.0;
  return {lat_deg, place.lon_deg + east_m / (111'320.0 * std::cos(geo::DegToRad(lat_deg)))};
}

// Lines of six photos, 20 m apart, there and back; no symmetric layout.
LatLon TakenAt(const LatLon& place, int k) {
  const int line = k / 6, along = line % 2 == 0 ? k % 6 : 5 - k % 6;
  return Beside(place, 20.0 * along + 3.0 * line, 31.0 * line + 1.5 * along);
}

std::string NameOf(int k) { return "DJI_" + std::to_string(100 + k) + ".JPG"; }

Flight FlightAt(const LatLon& place, int count = 18, bool has_positions = true) {
  Flight flight;
  for (int k = 0; k < count; ++k) {
    flight::Photo& photo = flight.photos.emplace_back();
    photo.name = NameOf(k);
    if (has_positions) photo.position.emplace().position = TakenAt(place, k);
  }
  return flight;
}

// A list of the flight as `write` puts each place.
template <typename Write>
FlightLog ListOf(const LatLon& place, int count, const Write& write, const std::string& system = "",
                 const std::string& format = "geo_txt") {
  FlightLog log;
  log.format = format;
  log.file_name = "list.txt";
  log.written_system = system;
  for (int k = 0; k < count; ++k) {
    flight::CameraEvent& event = log.events.emplace_back();
    event.t_s = k;
    event.has_time = false;
    event.image_name = NameOf(k);
    event.written = write(Beside(TakenAt(place, k), 4.0, 0.0));
    const auto plain = LatLon::Make(event.written->y, event.written->x);
    if (plain) event.position = *plain;
    event.yaw_pitch_roll_rad = Eigen::Vector3d(0.1, 0.2, 0.3);
  }
  return log;
}

flight::WrittenPlace AsDegrees(const LatLon& at) { return {at.lon_deg, at.lat_deg}; }
flight::WrittenPlace AsLatLon(const LatLon& at) { return {at.lat_deg, at.lon_deg}; }

// In a system of metres or feet.
auto In(int epsg) {
  return [epsg](const LatLon& at) {
    const auto there = geo::MapProjection::OfEpsg(epsg)->PlaceOf(at);
    return flight::WrittenPlace{there->x(), there->y()};
  };
}

template <typename Write>
auto NorthFirst(const Write& write) {
  return [write](const LatLon& at) {
    const flight::WrittenPlace there = write(at);
    return flight::WrittenPlace{there.y, there.x};
  };
}

// A flight after a list of its 18 photos was held against it.
Flight Compared(const LatLon& place, FlightLog list, bool has_positions = true) {
  Flight flight = FlightAt(place, 18, has_positions);
  flight.logs = {std::move(list)};
  EXPECT_TRUE(CompareSources(flight).ok());
  return flight;
}

// Every row 4 m east of the photos, whatever was written.
void ExpectTaken(const Flight& flight, const LatLon& place, const std::string& what) {
  ASSERT_EQ(flight.list_uses.size(), 1u) << what;
  EXPECT_EQ(flight.list_uses[0].fault, ListFault::kNone) << what << UseInWords(flight.list_uses[0]);
  EXPECT_EQ(flight.list_uses[0].rows_used, flight.logs[0].events.size()) << what;
  for (std::size_t k = 0; k < flight.logs[0].events.size(); ++k) {
    const auto& at = flight.logs[0].events[k].position;
    ASSERT_TRUE(at) << what;
    EXPECT_LT(geo::MetresApart(*at, Beside(TakenAt(place, static_cast<int>(k)), 4.0, 0.0)), 1.0) << what;
  }
}

void ExpectRefused(const Flight& flight, ListFault fault, const std::string& words) {
  ASSERT_EQ(flight.list_uses.size(), 1u);
  EXPECT_EQ(flight.list_uses[0].fault, fault);
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr(words)));
  for (const flight::CameraEvent& event : flight.logs[0].events) {
    EXPECT_FALSE(event.position);
    EXPECT_FALSE(event.yaw_pitch_roll_rad) << "angles of another flight are as wrong";
  }
}

TEST(CompareSources, BelievesAListThatAgreesWithoutAWord) {
  for (const LatLon& place : {kDuluth, kZurich, kSydney, kLaPaz}) {
    const Flight flight = Compared(place, ListOf(place, 18, AsDegrees, "EPSG:4326"));
    ExpectTaken(flight, place, "as written");
    EXPECT_NEAR(*flight.list_uses[0].apart_m, 4.0, 0.1);
    EXPECT_TRUE(flight.warnings.empty());
  }
}

TEST(CompareSources, ReadsDegreesBelowASystemOfMetresInEitherOrder) {
  for (const bool is_swapped : {false, true}) {
    for (const bool has_positions : {true, false}) {
      const Flight flight = Compared(kZurich,
                                     is_swapped ? ListOf(kZurich, 18, AsLatLon, "EPSG:32632")
                                                : ListOf(kZurich, 18, AsDegrees, "EPSG:32632"),
                                     has_positions);
      ExpectTaken(flight, kZurich, is_swapped ? "latitude first" : "longitude first");
      EXPECT_EQ(flight.list_uses[0].reading.counts_in, CountsIn::kDegrees);
      EXPECT_EQ(flight.list_uses[0].reading.is_swapped, is_swapped);
      EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("as written")));
    }
  }
}

TEST(CompareSources, SaysHowFarOffTheListWouldLieAsWritten) {
  const Flight flight = Compared(kDuluth, ListOf(kDuluth, 18, AsLatLon, "EPSG:32615"));
  EXPECT_THAT(InWords(flight.warnings),
              Contains(HasSubstr("list.txt: read as latitude, longitude in degrees: as written it "
                                 "would lie 5,2")));
}

TEST(CompareSources, ReadsExchangedCoordinates) {
  for (const LatLon& place : {kDuluth, kZurich, kSydney, kLaPaz}) {
    const Flight flight = Compared(place, ListOf(place, 18, AsLatLon, "EPSG:4326"));
    ExpectTaken(flight, place, "exchanged");
    EXPECT_FALSE(flight.list_uses[0].is_as_written);
  }
  // Also where both orders lie near each other and only the layout tells.
  const LatLon diagonal{10.0004, 10.0};
  const Flight flight = Compared(diagonal, ListOf(diagonal, 18, AsLatLon, "EPSG:4326"));
  ExpectTaken(flight, diagonal, "on the diagonal");
}

TEST(CompareSources, ReadsMetresOfTheZoneOfThePhotos) {
  for (const auto& [place, code] :
       {std::pair{kDuluth, 32615}, std::pair{kZurich, 32632}, std::pair{kSydney, 32756}}) {
    for (const bool is_swapped : {false, true}) {
      const Flight flight =
          Compared(place, is_swapped ? ListOf(place, 18, NorthFirst(In(code)), "", "pix4d_csv")
                                     : ListOf(place, 18, In(code), "", "pix4d_csv"));
      ExpectTaken(flight, place, "zone " + std::to_string(code));
      EXPECT_EQ(flight.list_uses[0].reading.utm_code, code);
      EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("EPSG:" + std::to_string(code))));
    }
  }
  // At a zone's edge the neighbour's counts too.
  const LatLon edge{47.0, 11.95};
  const Flight flight = Compared(edge, ListOf(edge, 18, In(32633), "", "pix4d_csv"));
  ExpectTaken(flight, edge, "zone 33 at 11.95 E");
}

TEST(CompareSources, AsksForTheSystemOfMetresThatNothingPlaces) {
  const Flight flight = Compared(kDuluth, ListOf(kDuluth, 18, In(32615), "", "pix4d_csv"), false);
  ExpectRefused(flight, ListFault::kNoSystem, "write the system's EPSG code");
}

TEST(CompareSources, ReadsFeetAndSystemsOfAnyName) {
  const Flight flight =
      Compared(kDuluth, ListOf(kDuluth, 18, In(26849), "NAD83 / Minnesota North (ftUS)"));  // US survey feet
  ExpectTaken(flight, kDuluth, "state plane");
  EXPECT_TRUE(flight.list_uses[0].is_as_written);
  const Flight wrong_zone = Compared(kDuluth, ListOf(kDuluth, 18, In(32615), "EPSG:32616"));
  ExpectTaken(wrong_zone, kDuluth, "the neighbour's zone is named");
  EXPECT_EQ(wrong_zone.list_uses[0].reading.utm_code, 32615);
}

TEST(CompareSources, ReadsWestAndSouthWithoutASign) {
  for (const LatLon& place : {kDuluth, kSydney, kLaPaz}) {
    const Flight flight =
        Compared(place, ListOf(
                            place, 18,
                            [](const LatLon& at) {
                              return flight::WrittenPlace{std::abs(at.lon_deg), std::abs(at.lat_deg)};
                            },
                            "EPSG:4326"));
    ExpectTaken(flight, place, "without signs");
    EXPECT_EQ(flight.list_uses[0].reading.west_is_positive, place.lon_deg < 0.0);
    EXPECT_EQ(flight.list_uses[0].reading.south_is_positive, place.lat_deg < 0.0);
  }
}

TEST(CompareSources, RefusesTheListOfAnotherFlight) {
  for (const double far_m : {3'000.0, 40'000.0, 2'000'000.0}) {
    const Flight flight = Compared(kDuluth, ListOf(Beside(kDuluth, 0.0, -far_m), 18, AsDegrees, "EPSG:4326"));
    ExpectRefused(flight, ListFault::kFarAway, "another flight");
  }
}

TEST(CompareSources, RefusesAListThatIsLaidOutOtherwise) {
  for (const int kind : {0, 1, 2}) {
    FlightLog list = ListOf(kDuluth, 18, AsDegrees, "EPSG:4326");
    std::vector<flight::WrittenPlace> places;
    for (const auto& event : list.events) places.push_back(*event.written);
    std::mt19937 random(5);
    if (kind == 0) std::shuffle(places.begin(), places.end(), random);
    if (kind == 1) std::reverse(places.begin(), places.end());
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (kind == 2) places[k].x = 2.0 * kDuluth.lon_deg - places[k].x;  // mirrored
      list.events[k].written = places[k];
    }
    ExpectRefused(Compared(kDuluth, list), ListFault::kOtherShape, "laid out otherwise");
  }
}

// The receiver lost its fix, and every photo carries the last one: it refuses no list.
TEST(CompareSources, LetsNoStaleFixOutvoteAList) {
  for (const LatLon& fix : {Beside(kDuluth, 2'500.0, 0.0), kZurich}) {
    Flight flight = FlightAt(kDuluth);
    for (flight::Photo& photo : flight.photos) photo.position->position = fix;
    flight.logs = {ListOf(kDuluth, 18, AsDegrees, "EPSG:4326")};
    ASSERT_TRUE(CompareSources(flight).ok());
    ExpectTaken(flight, kDuluth, "over a stale fix");
  }
  Flight swapped = FlightAt(kZurich);
  for (flight::Photo& photo : swapped.photos) photo.position->position = Beside(kZurich, 800.0, 300.0);
  swapped.logs = {ListOf(kZurich, 18, AsLatLon, "EPSG:4326")};
  ASSERT_TRUE(CompareSources(swapped).ok());
  ExpectTaken(swapped, kZurich, "it still says roughly where");
}

TEST(CompareSources, TakesTheDocumentedOrderAloneAndSaysWhereTheOtherWouldLie) {
  const Flight flight = Compared(kZurich, ListOf(kZurich, 18, AsDegrees, "EPSG:4326"), false);
  ExpectTaken(flight, kZurich, "longitude first, as geo.txt has it");
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("the order of its format")));
  const Flight far_west = Compared(kDuluth, ListOf(kDuluth, 18, AsLatLon, "EPSG:4326"), false);
  ExpectTaken(far_west, kDuluth, "no latitude is 92 degrees");
}

TEST(CompareSources, AsksWhereTwoReadingsStayPossible) {
  Flight flight = FlightAt(kZurich, 18, false);
  flight.logs = {ListOf(kZurich, 18, AsDegrees, "", "pix4d_csv")};
  flight.logs[0].written_order_is_assumed = true;
  const auto open = CompareSources(flight);
  ASSERT_FALSE(open.ok());
  EXPECT_EQ(open.error().code, ErrorCode::kUnprocessable);
  EXPECT_THAT(open.error().message, HasSubstr("47.4"));
  EXPECT_THAT(open.error().message, HasSubstr("image,longitude,latitude"));
  // A track, or another list, answers it.
  Flight tracked = FlightAt(kZurich, 18, false);
  tracked.logs = flight.logs;
  FlightLog& track = tracked.logs.emplace_back();
  track.gnss.emplace_back().position = Beside(kZurich, 500.0, 0.0);
  ASSERT_TRUE(CompareSources(tracked).ok());
  ExpectTaken(tracked, kZurich, "with a track");
}

// The flight at Duluth and a list of it whose times lie so many days behind those of the photos.
Flight ComparedDaysLater(int days, bool has_positions, bool has_local_clock = false) {
  const flight::UtcTime noon{std::chrono::seconds(1'717'243'200)};
  FlightLog list = ListOf(kDuluth, 18, AsDegrees, "EPSG:4326");
  list.utc_at_zero = noon + std::chrono::days(days);
  for (flight::CameraEvent& event : list.events) event.has_time = true;
  Flight flight = FlightAt(kDuluth, 18, has_positions);
  for (std::size_t k = 0; k < flight.photos.size(); ++k) {
    flight.photos[k].captured_at = noon + std::chrono::seconds(k);
    flight.photos[k].captured_at_is_local = has_local_clock;
  }
  flight.logs = {std::move(list)};
  EXPECT_TRUE(CompareSources(flight).ok());
  return flight;
}

TEST(CompareSources, RefusesTheListOfAnotherDay) {
  ExpectRefused(ComparedDaysLater(7, true), ListFault::kOtherTime, "7 days from those of the photos");
  const Flight alone = ComparedDaysLater(7, false);
  ExpectTaken(alone, kDuluth, "nothing else places them");
  EXPECT_THAT(InWords(alone.warnings), Contains(HasSubstr("may be the list of another flight")));
}

TEST(CompareSources, TakesNoClocksErrorForAnotherDay) {
  for (const int days : {0, 1, 1024 * 7}) {
    const Flight flight = ComparedDaysLater(days, true);
    ExpectTaken(flight, kDuluth, "a wrong date, or weeks of GPS counted anew");
    EXPECT_TRUE(flight.warnings.empty()) << days;
  }
  ExpectTaken(ComparedDaysLater(7, true, true), kDuluth, "the camera's clock was never set");
}

TEST(CompareSources, JudgesHalfAListAndNamesOneThatNamesNoPhoto) {
  const Flight flight = Compared(kDuluth, ListOf(kDuluth, 9, AsDegrees, "EPSG:4326"));
  ExpectTaken(flight, kDuluth, "nine of eighteen");
  Flight other = FlightAt(kDuluth);
  other.logs = {ListOf(kDuluth, 3, AsDegrees, "EPSG:4326")};
  for (flight::CameraEvent& event : other.logs[0].events) event.image_name = "x" + *event.image_name;
  ASSERT_TRUE(CompareSources(other).ok());
  EXPECT_EQ(other.list_uses[0].fault, ListFault::kNamesNoPhoto);
}

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

TEST(CompareSources, FindsThePhotosOfMarksAsItFindsThoseOfRows) {
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

TEST(CompareSources, SaysWhyMarksAreInNoPhoto) {
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

TEST(CompareSources, RefusesAListWhosePixelsLieOutsideItsPhotos) {
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

TEST(CompareSources, SaysWhatTheSystemOfASurveyIsKnownTo) {
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

TEST(CompareSources, JudgesSurveyedPointsByThePhotosThatShowThem) {
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

// Of two cards the photo of one could not be read, so that both rows fall on the other's.
TEST(CompareSources, UsesNeitherOfTwoRowsThatGiveAPhotoDifferentPlaces) {
  FlightLog list = ListOf(kDuluth, 18, AsDegrees, "EPSG:4326");
  flight::CameraEvent& same = list.events.emplace_back(list.events[2]);
  same.image_name = "DJI_102.DNG";
  flight::CameraEvent& other = list.events.emplace_back(list.events[4]);
  other.image_name = "101MEDIA/DJI_105.JPG";
  const Flight flight = Compared(kDuluth, list);
  EXPECT_EQ(flight.list_uses[0].rows_used, 18u) << "of twenty";
  const std::vector<flight::CameraEvent>& events = flight.logs[0].events;
  EXPECT_FALSE(events[5].position || events[19].position);
  EXPECT_FALSE(events[5].yaw_pitch_roll_rad || events[19].yaw_pitch_roll_rad);
  EXPECT_TRUE(events[2].position && events[18].position) << "they agree";
  EXPECT_THAT(InWords(flight.warnings),
              Contains(HasSubstr("2 rows (the first is DJI_105.JPG) are not used")));
}

TEST(CompareSources, NamesMarksByThePhotosOfTheirFolders) {
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

// Any place, order, sign and system: right to a metre, or refused.
TEST(CompareSources, NeverBelievesAReadingThatIsWrong) {
  std::mt19937 random(36);
  std::uniform_real_distribution<double> lat(-70.0, 75.0), lon(-179.0, 179.0);
  std::uniform_int_distribution<int> pick(0, 5);
  int taken = 0;
  constexpr int kLists = 500;
  for (int round = 0; round < kLists; ++round) {
    const LatLon place{lat(random), lon(random)};
    const int zone = geo::UtmCodeOf(place);
    Flight flight = FlightAt(place, 12);
    const auto as_metres = In(zone);
    const std::string system = "EPSG:" + std::to_string(zone);
    switch (pick(random)) {
      case 0:
        flight.logs = {ListOf(place, 12, AsLatLon, "EPSG:4326")};
        break;
      case 1:
        flight.logs = {ListOf(place, 12, AsLatLon, system)};
        break;
      case 2:
        flight.logs = {ListOf(place, 12, NorthFirst(as_metres), system)};
        break;
      case 3:
        flight.logs = {ListOf(place, 12, as_metres, "EPSG:4326")};
        break;
      case 4:
        flight.logs = {ListOf(place, 12, NorthFirst(as_metres), "")};
        break;
      default:
        flight.logs = {ListOf(
            place, 12,
            [](const LatLon& at) {
              return flight::WrittenPlace{-at.lon_deg, at.lat_deg};
            },
            "")};
    }
    ASSERT_TRUE(CompareSources(flight).ok());
    if (flight.list_uses[0].fault != ListFault::kNone) continue;
    ++taken;
    for (int k = 0; k < 12; ++k) {
      const auto& at = flight.logs[0].events[static_cast<std::size_t>(k)].position;
      ASSERT_TRUE(at) << round;
      ASSERT_LT(geo::MetresApart(*at, Beside(TakenAt(place, k), 4.0, 0.0)), 1.0)
          << round << " " << UseInWords(flight.list_uses[0]);
    }
  }
  EXPECT_GT(taken, kLists * 9 / 10);
}

}  // namespace
}  // namespace skyquilt::poses
