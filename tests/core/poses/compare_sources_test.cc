#include "core/poses/lists/compare_sources.h"

#include <algorithm>
#include <chrono>
#include <random>
#include <tuple>

#include "core/geo/crs/reference_system.h"
#include "core/poses/lists/judge_list.h"
#include "core/poses/photo_rows.h"
#include "tests/core/poses/listed_flight.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::CountsIn;

TEST(CompareSources, BelievesAListThatAgreesWithoutAWord) {
  for (const LatLon& place : {kDuluth, kZurich, kSydney, kLaPaz}) {
    const Flight flight = Compared(place, ListOf(place, 18, AsDegrees, "EPSG:4326"));
    ExpectTaken(flight, place, "as written");
    EXPECT_NEAR(*flight.list_uses[0].apart_m, 4.0, 0.1);
    EXPECT_TRUE(flight.warnings.empty());
  }
}

// A list of degrees in steps, whose rows claim centimetres or nothing.
Flight ComparedInSteps(double steps_a_degree, bool claims) {
  const auto in_steps = [&](double deg) { return std::round(deg * steps_a_degree) / steps_a_degree; };
  const auto write = [&](const LatLon& at) {
    return flight::WrittenPlace{in_steps(at.lon_deg), in_steps(at.lat_deg)};
  };
  FlightLog list = ListOf(kZurich, 18, write, "EPSG:4326");
  for (flight::CameraEvent& row : list.events) {
    if (claims) row.sigma_in_ned_m = Eigen::Vector3d(0.02, 0.02, 0.03);
    row.is_rtk_fixed = claims;
  }
  return Compared(kZurich, std::move(list));
}

// Four decimals of a degree, tenths of a second; a metre is no news of a receiver, ten are.
TEST(CompareSources, BelievesNoListMoreThanTheStepOfItsNumbers) {
  for (const auto& [steps_a_degree, claims, step_m] :
       {std::tuple(1e4, true, 9.5), {1e4, false, 9.5}, {36'000.0, true, 2.6}, {1e5, true, 0.95}}) {
    const Flight flight = ComparedInSteps(steps_a_degree, claims);
    SCOPED_TRACE(steps_a_degree);
    ASSERT_EQ(flight.list_uses.size(), 1u);
    ASSERT_TRUE(flight.list_uses[0].rounded_to_m);
    EXPECT_NEAR(*flight.list_uses[0].rounded_to_m, step_m, 0.05 * step_m);
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("rounded")));
    for (const flight::CameraEvent& row : flight.logs[0].events) {
      ASSERT_TRUE(row.sigma_in_ned_m);
      EXPECT_NEAR(row.sigma_in_ned_m->x(), step_m / std::sqrt(12.0), 0.02 * step_m);
      EXPECT_FALSE(row.is_rtk_fixed);
    }
  }
  for (const auto& [steps_a_degree, claims] : {std::pair(1e8, true), {1e5, false}}) {
    const Flight flight = ComparedInSteps(steps_a_degree, claims);
    EXPECT_TRUE(flight.warnings.empty()) << steps_a_degree;
    EXPECT_EQ(flight.logs[0].events[0].is_rtk_fixed, claims);
  }
}

TEST(CompareSources, BelievesNoTrackMoreThanTheStepOfItsNumbers) {
  const auto fix_of = [](double steps_a_degree) {
    Flight flight = FlightAt(kZurich, 18, false);
    FlightLog& track = flight.logs.emplace_back();
    for (int k = 0; k < 18; ++k) {
      flight::GnssSample& fix = track.gnss.emplace_back();
      fix.t_s = k;
      const LatLon at = TakenAt(Beside(kZurich, 3.0, 2.0), k);
      fix.position = {std::round(at.lat_deg * steps_a_degree) / steps_a_degree,
                      std::round(at.lon_deg * steps_a_degree) / steps_a_degree};
    }
    EXPECT_TRUE(CompareSources(flight).ok());
    EXPECT_EQ(flight.warnings.empty(), steps_a_degree > 1e4) << steps_a_degree;
    return flight.logs[0].gnss[0];
  };
  EXPECT_NEAR(fix_of(1e4).sigma_horizontal_m.value_or(0.0), 11.1 / std::sqrt(12.0), 0.05);
  for (const double steps_a_degree : {1e5, 1e7}) EXPECT_FALSE(fix_of(steps_a_degree).sigma_horizontal_m);
}

TEST(CompareSources, LetsPhotosKnowToWhatTheSystemOfTheirListIsKnown) {
  const LatLon milan{45.46, 9.19};
  for (const auto& [epsg, is_known] : {std::pair{3003, false}, std::pair{32632, true}}) {  // Monte Mario, UTM
    Flight flight = Compared(milan, ListOf(milan, 18, In(epsg), "EPSG:" + std::to_string(epsg)));
    ASSERT_EQ(flight.list_uses[0].fault, ListFault::kNone);
    ApplyPhotoRows(flight.logs, flight.photos);
    for (const flight::Photo& photo : flight.photos)
      EXPECT_EQ(photo.position->system_error_m.value_or(0.0) <= 1.0, is_known) << epsg;
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
    ExpectTaken(Compared(flight, ListOf(kDuluth, 18, AsDegrees, "EPSG:4326")), kDuluth, "over a stale fix");
  }
  Flight swapped = FlightAt(kZurich);
  for (flight::Photo& photo : swapped.photos) photo.position->position = Beside(kZurich, 800.0, 300.0);
  ExpectTaken(Compared(swapped, ListOf(kZurich, 18, AsLatLon, "EPSG:4326")), kZurich,
              "it still says roughly where");
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
  const Error open = test::ErrorOf(CompareSources(flight));
  EXPECT_EQ(open.code, ErrorCode::kUnprocessable);
  EXPECT_THAT(open.message, HasSubstr("47.4"));
  EXPECT_THAT(open.message, HasSubstr("image,longitude,latitude"));
  // A track, or another list, answers it.
  Flight tracked = FlightAt(kZurich, 18, false);
  tracked.logs = flight.logs;
  FlightLog& track = tracked.logs.emplace_back();
  track.gnss.emplace_back().position = Beside(kZurich, 500.0, 0.0);
  ASSERT_TRUE(CompareSources(tracked).ok());
  ExpectTaken(tracked, kZurich, "with a track");
}

TEST(CompareSources, SaysThatPlacesLieWhereRadiansDo) {
  const auto as_radians = [](const LatLon& at) {
    return flight::WrittenPlace{geo::DegToRad(at.lon_deg), geo::DegToRad(at.lat_deg)};
  };
  for (const LatLon& place : {kDuluth, kZurich, kSydney, kLaPaz}) {
    const Flight flight = Compared(place, ListOf(place, 18, as_radians, "EPSG:4326"), false);
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("as radians do")));
    const Flight in_degrees = Compared(place, ListOf(place, 18, AsDegrees, "EPSG:4326"), false);
    EXPECT_THAT(InWords(in_degrees.warnings), ::testing::Not(Contains(HasSubstr("radians"))));
  }
}

// Degrees of NAD27 under the name of WGS 84 lie so far aside; a receiver that lags behind does on each line.
TEST(CompareSources, SaysThatAllRowsLieAsideByMoreThanReceiversErr) {
  const auto said = [](Flight flight, double east_m) {
    FlightLog list = ListOf(Beside(kDuluth, east_m - 4.0, 5.0), 18, AsDegrees, "EPSG:4326");
    return InWords(Compared(std::move(flight), std::move(list)).warnings);
  };
  const auto is_told = Contains(HasSubstr("It is believed all the same"));
  EXPECT_THAT(said(FlightAt(kDuluth), -26.0), is_told);
  EXPECT_THAT(said(FlightAt(kDuluth), -12.0), ::testing::Not(is_told));
  Flight lagging = FlightAt(kDuluth);
  for (int k = 0; k < 18; ++k) {
    const double behind_m = k / 6 % 2 == 0 ? 25.0 : -25.0;
    lagging.photos[static_cast<std::size_t>(k)].position->position =
        Beside(TakenAt(kDuluth, k), -behind_m, 0.0);
  }
  EXPECT_THAT(said(lagging, 4.0), ::testing::Not(is_told));
}

// "UTM 30S" by the letter of MGRS, as lists of Spain are; alone it lies in the sea at 53 degrees south.
TEST(CompareSources, SaysThatBandSIsNoSouthernHalf) {
  const LatLon seville{37.4, -5.0};
  const auto said = [](const LatLon& place, int epsg, const std::string& system, bool has_positions) {
    return InWords(Compared(place, ListOf(place, 18, In(epsg), system), has_positions).warnings);
  };
  EXPECT_THAT(said(seville, 32630, "EPSG:32730", false),
              Contains(HasSubstr("write UTM zone 30N or EPSG:32630")));
  for (const auto& words :
       {said(seville, 32630, "EPSG:32630", false), said(seville, 32630, "EPSG:32730", true),
        said(kSydney, 32756, "EPSG:32756", false)})
    EXPECT_THAT(words, ::testing::Not(Contains(HasSubstr("MGRS"))));
}

TEST(CompareSources, CountsKappaFromTheNorthOfThePlane) {
  constexpr double kWritten = 0.1;  // ListOf's
  const auto yaw_of = [](FlightLog list, bool is_kappa) {
    for (flight::CameraEvent& row : list.events) row.yaw_is_from_grid_north = is_kappa;
    return Compared(kDuluth, std::move(list)).logs[0].events[0].yaw_pitch_roll_rad.value().x();
  };
  // A degree east of the middle of zone 15.
  const double north_rad = geo::DegToRad((kDuluth.lon_deg + 93.0) * std::sin(geo::DegToRad(kDuluth.lat_deg)));
  const auto as_metres = In(32615);
  EXPECT_NEAR(yaw_of(ListOf(kDuluth, 18, as_metres, "EPSG:32615"), true), kWritten + north_rad, 1e-4);
  EXPECT_NEAR(yaw_of(ListOf(kDuluth, 18, NorthFirst(as_metres), "EPSG:32615"), true), kWritten + north_rad,
              1e-4);
  EXPECT_EQ(yaw_of(ListOf(kDuluth, 18, as_metres, "EPSG:32615"), false), kWritten) << "a compass's";
  EXPECT_EQ(yaw_of(ListOf(kDuluth, 18, AsDegrees, "EPSG:4326"), true), kWritten) << "no plane";
}

// The flight at Duluth and a list of it whose times lie so many days behind those of the photos.
Flight ComparedDaysLater(int days, bool has_positions, bool has_receiver = true) {
  const flight::UtcTime noon{std::chrono::seconds(1'717'243'200)};
  FlightLog list = ListOf(kDuluth, 18, AsDegrees, "EPSG:4326");
  list.utc_at_zero = noon + std::chrono::days(days);
  for (flight::CameraEvent& event : list.events) event.has_time = true;
  Flight flight = FlightAt(kDuluth, 18, has_positions);
  for (std::size_t k = 0; k < flight.photos.size(); ++k) {
    flight.photos[k].captured_at = noon + std::chrono::seconds(k);
    if (has_receiver) flight.photos[k].receiver_time = flight.photos[k].captured_at;
  }
  return Compared(std::move(flight), std::move(list));
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
  ExpectTaken(ComparedDaysLater(7, true, false), kDuluth, "the camera's clock was never set");
}

TEST(CompareSources, JudgesHalfAListAndNamesOneThatNamesNoPhoto) {
  const Flight flight = Compared(kDuluth, ListOf(kDuluth, 9, AsDegrees, "EPSG:4326"));
  ExpectTaken(flight, kDuluth, "nine of eighteen");
  FlightLog other = ListOf(kDuluth, 3, AsDegrees, "EPSG:4326");
  for (flight::CameraEvent& event : other.events) event.image_name = "x" + *event.image_name;
  EXPECT_EQ(Compared(kDuluth, other).list_uses[0].fault, ListFault::kNamesNoPhoto);
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
    const auto as_metres = In(zone);
    const std::string system = "EPSG:" + std::to_string(zone);
    const auto west_positive = [](const LatLon& at) { return flight::WrittenPlace{-at.lon_deg, at.lat_deg}; };
    const FlightLog lists[] = {
        ListOf(place, 12, AsLatLon, "EPSG:4326"),         ListOf(place, 12, AsLatLon, system),
        ListOf(place, 12, NorthFirst(as_metres), system), ListOf(place, 12, as_metres, "EPSG:4326"),
        ListOf(place, 12, NorthFirst(as_metres)),         ListOf(place, 12, west_positive)};
    const Flight flight = Compared(FlightAt(place, 12), lists[pick(random)]);
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
