// Surveyed points of a flight's files, and a finished flight whose truth is known, displaced as a whole,
// brought back by them.
#include "core/pipeline/placing/place_by_lists.h"

#include <gmock/gmock.h>

#include <cmath>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/placing/control_points.h"
#include "core/pipeline/placing/place_known.h"
#include "tests/core/pipeline/displaced_flight.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

using test::ErrorOf;
using test::ValueOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

flight::GcpList Read(std::string_view text) {
  return ValueOf(flight::ParseGcpList("gcp_list.txt", flight::BytesOf(text)));
}

TEST(ControlPoints, HaveNoHeightsWhereAllAreZero) {
  const std::string rows =
      "EPSG:4326\n7.1 46.8 0 100 200 A.JPG a\n7.2 46.8 0.00 100 200 A.JPG b\n7.1 46.9 0.0 100 200 A.JPG c\n";
  const flight::GcpList list = Read(rows);
  ASSERT_EQ(list.warnings.size(), 1u);
  EXPECT_EQ(list.warnings[0].code, flight::RemarkCode::kHeightsNotSurveyed);
  for (const auto& point : ControlPointsOf({list})) EXPECT_FALSE(point.height_m) << point.name;
  const auto one_high = ControlPointsOf({Read(rows + "7.2 46.9 0.4 100 200 A.JPG d\n")});
  ASSERT_EQ(one_high.size(), 4u);
  EXPECT_EQ(one_high[0].height_m, 0.0);
  const auto few = ControlPointsOf({Read("EPSG:4326\n7.1 46.8 0 100 200 A.JPG a\n")});
  EXPECT_EQ(few[0].height_m, 0.0);
}

TEST(ControlPoints, HaveNoHeightsThatNoGroundHas) {
  const flight::GcpList list =
      Read("EPSG:32632\n500000 5180000 -9999 100 200 A.JPG a\n500010 5180000 403.5 100 200 A.JPG b\n");
  ASSERT_EQ(list.warnings.size(), 1u);
  EXPECT_EQ(list.warnings[0].code, flight::RemarkCode::kHeightsBeyond);
  const auto points = ControlPointsOf({list});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_FALSE(points[0].height_m);
  EXPECT_EQ(points[1].height_m, 403.5);
}

TEST(ControlPoints, CountPixelsFromTheMiddleOfTheFirstAndGatherSightingsOfAPoint) {
  const auto points =
      ControlPointsOf({Read("EPSG:4326\n"
                            "7.1 46.8 500 100.5 200.5 A.JPG north\n"
                            "7.1 46.8 500 300.5 250.0 B.JPG north\n"
                            "7.2 46.9 510 30 40 B.JPG south\n")});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].name, "north");
  EXPECT_NEAR(points[0].position.lat_deg, 46.8, 1e-9);
  ASSERT_EQ(points[0].sightings.size(), 2u);
  EXPECT_EQ(points[0].sightings[0].pixel_in_image, Eigen::Vector2d(100.0, 200.0));
  EXPECT_EQ(points[1].sightings[0].photo_name, "B.JPG");
}

TEST(ControlPoints, OfSeveralListsStandBesideEachOther) {
  const flight::GcpList list = Read("EPSG:4326\n7.1 46.8 500 100.5 200.5 A.JPG\n");
  const auto points = ControlPointsOf({list, list});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].sightings.size(), 1u);
}

TEST(ControlPoints, ThatNoPhotoIsMarkedWithAreLeftOut) {
  const auto points = ControlPointsOf(
      {Read("EPSG:4326\n7.1 46.8 500 0 0 - a\n7.2 46.8 500 100.5 200.5 A.JPG b\n7.3 46.8 500 0 0 - c\n")});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].name, "b");
}

TEST(ControlPoints, WhoseNamesEndInCheckPlaceNothing) {
  const std::vector<flight::GcpList> lists{
      Read("EPSG:4326\n7.1 46.8 500 100 200 A.JPG a\n7.2 46.8 500 100 200 A.JPG b_Check\n"
           "7.3 46.8 500 100 200 A.JPG c check\n7.4 46.8 500 100 200 A.JPG checkerboard\n")};
  ASSERT_EQ(ControlPointsOf(lists).size(), 2u);
  EXPECT_EQ(ControlPointsOf(lists)[1].name, "checkerboard");
  ASSERT_EQ(CheckPointsOf(lists).size(), 2u);
  EXPECT_EQ(CheckPointsOf(lists)[0].name, "b_Check");
  EXPECT_EQ(CheckPointsOf(lists)[1].name, "c_check");
}

TEST(ControlPoints, MayBeNamedCheckPointsByAColumn) {
  const std::vector<flight::GcpList> lists{
      Read("EPSG:4326\nlon,lat,z,px,py,image,name,check\n7.1,46.8,500,100,200,A.JPG,a,yes\n"
           "7.2,46.8,500,100,200,A.JPG,b,0\n7.3,46.8,500,100,200,A.JPG,c,\n")};
  EXPECT_EQ(ControlPointsOf(lists).size(), 2u);
  ASSERT_EQ(CheckPointsOf(lists).size(), 1u);
  EXPECT_EQ(CheckPointsOf(lists)[0].name, "a_check");
}

TEST(ControlPoints, OfNoListAreNone) { EXPECT_TRUE(ControlPointsOf({}).empty()); }

class BySomePoints : public testing::TestWithParam<std::size_t> {};

TEST_P(BySomePoints, AShiftedFlightComesBack) {
  const Displaced flight({0.0, 1.0, {1.9, -2.6}});
  EXPECT_GT(flight.WorstCameraM(flight.known), 3.0);
  const auto moved = test::ValueOf(MoveToControl(flight.known, flight.Survey(GetParam())));
  EXPECT_LT(flight.WorstCameraM(moved), 0.01);
  EXPECT_FALSE(moved.appearance.has_value());
  EXPECT_EQ(moved.flight.warnings.size(), 1u);
}

INSTANTIATE_TEST_SUITE_P(OneToFour, BySomePoints, testing::Values(1u, 2u, 3u, 4u));

TEST(MoveToControl, TurnsAndStretchesByPointsThatLieFarApart) {
  Displaced flight({0.02, 1.01, {-1.2, 0.7}});
  EXPECT_GT(flight.WorstTurnRad(flight.known), 0.015);
  // As far as it truly moved while it read its rows, turned and stretched with the flight.
  const Eigen::Vector3d truly_m(1e-3, -2e-3, 5e-4);
  flight.known.flight.photos.front().readout_motion.shift_in_enu_m =
      1.01 * (Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitZ()) * truly_m);
  for (const std::size_t points : {2u, 3u, 4u}) {
    const auto moved = test::ValueOf(MoveToControl(flight.known, flight.Survey(points)));
    EXPECT_LT(flight.WorstCameraM(moved), 0.01);
    EXPECT_LT(flight.WorstTurnRad(moved), 1e-4);
    EXPECT_LT((moved.flight.photos.front().readout_motion.shift_in_enu_m - truly_m).norm(), 1e-6);
    EXPECT_LT(moved.flight.photos.front().error_radius_m, 0.1);
  }
}

TEST(MoveToControl, TakesTheGroundAlong) {
  Displaced flight({0.0, 1.0, {2.0, 0.0}});
  // A ramp that rises to the east, one metre in ten.
  std::vector<float> heights_m;
  for (int row = 0; row < 21; ++row) {
    for (int column = 0; column < 21; ++column) heights_m.push_back(static_cast<float>(column - 10));
  }
  flight.known.ground =
      ground::GroundSurface::Grid({-100.0, -100.0}, 10.0, 21, 21, std::move(heights_m), 0.0);
  const auto moved = test::ValueOf(MoveToControl(flight.known, flight.Survey(1)));
  for (const double east : {-50.0, 3.0, 41.0}) {
    EXPECT_NEAR(moved.ground.HeightAt({east, 5.0}), flight.known.ground.HeightAt({east + 2.0, 5.0}), 1e-3);
  }
}

TEST(MoveToControl, OfLessThanAnyPixelWouldShowChangesNothing) {
  const Displaced flight({0.0, 1.0, {0.0002, 0.0}});
  const auto moved = test::ValueOf(MoveToControl(flight.known, flight.Survey(3)));
  EXPECT_TRUE(moved.appearance.has_value());
  EXPECT_EQ(flight.WorstCameraM(moved), flight.WorstCameraM(flight.known));
  EXPECT_TRUE(moved.flight.warnings.empty());
}

TEST(MoveToControl, LeavesManyPointsToTheAlignment) {
  const Displaced flight({0.0, 1.0, {1.0, 1.0}});
  EXPECT_FALSE(MoveToControl(flight.known, flight.Survey(5)).has_value());
  EXPECT_FALSE(MoveToControl(flight.known, {}).has_value());
}

TEST(MoveToControl, LeavesPointsThatOnlyABentFlightFitsToTheAlignment) {
  const Displaced flight({0.0, 1.0, {1.0, 1.0}});
  EXPECT_FALSE(MoveToControl(flight.known, flight.Survey(4, {1.5, 0.0, 0.0})).has_value());
  const Displaced turned({0.2, 1.0, {}});
  EXPECT_FALSE(MoveToControl(turned.known, turned.Survey(3)).has_value());
}

TEST(MoveToControl, LeavesPointsThatWouldTurnOrStretchCorrectedPositionsToTheAlignment) {
  Displaced flight({0.0, 1.0, {1.0, 0.0}});
  flight.known.align_report.emplace();
  const std::vector<flight::GcpList> wrong = flight.Survey(2, {1.0, 0.0, 0.0});
  EXPECT_TRUE(MoveToControl(flight.known, wrong).has_value()) << "a receiver alone knows no better";
  for (alignment::AlignedPhoto& photo : flight.known.flight.photos) photo.photo.position->is_rtk_fixed = true;
  EXPECT_FALSE(MoveToControl(flight.known, wrong).has_value());
  EXPECT_TRUE(MoveToControl(flight.known, flight.Survey(2)).has_value()) << "base and survey may lie apart";
  bool contradict = false;
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, wrong)).message, HasSubstr("two surveyed points"));
  EXPECT_FALSE(PlaceByLists(flight.known, flight.Survey(3, {1.0, 0.0, 0.0}), &contradict).ok());
  EXPECT_TRUE(contradict);
}

TEST(MoveToControl, NamesAPointThatItCannotUse) {
  const Displaced flight({0.0, 1.0, {1.0, 0.0}});
  std::vector<flight::GcpList> lists = flight.Survey(2);
  std::vector<flight::GcpSighting>& sightings = lists.front().sightings;
  const auto first_of_second = std::find_if(sightings.begin(), sightings.end(),
                                            [](const flight::GcpSighting& one) { return one.point == 1; });
  sightings.erase(first_of_second + 1, sightings.end());
  const auto moved = test::ValueOf(MoveToControl(flight.known, lists));
  EXPECT_LT(flight.WorstCameraM(moved), 0.01);
  ASSERT_EQ(moved.flight.warnings.size(), 2u);
  EXPECT_NE(InWords(moved.flight.warnings.front()).find("point1 is not used"), std::string::npos);
}

TEST(MoveToControl, ASinglePointMakesNoOneSurer) {
  const Displaced flight({0.0, 1.0, {1.0, 0.0}});
  const auto moved = test::ValueOf(MoveToControl(flight.known, flight.Survey(1)));
  EXPECT_EQ(moved.flight.photos.front().error_radius_m, 1.5);
}

TEST(MoveToControl, TwoPointsSayWhereAMapLiesThatWasPlacedByHand) {
  Displaced flight({0.0, 1.0, {1.0, 0.0}});
  flight.known.is_by_hand = true;
  flight.known.flight.warnings.push_back({flight::RemarkCode::kControlOverruled, {{"points", 4}}});
  flight.known.flight.warnings.push_back(
      {flight::RemarkCode::kPlacedByOrigin,
       {{"lat_deg", 46.8}, {"lon_deg", 7.1}, {"turn_deg", 0.0}, {"times", 1.0}}});
  const auto by_one = ValueOf(MoveToControl(flight.known, flight.Survey(1)));
  EXPECT_TRUE(by_one.is_by_hand) << "it has nothing to be checked against";
  EXPECT_THAT(InWords(by_one.flight.warnings), Contains(HasSubstr("placed by hand now")));
  EXPECT_THAT(InWords(by_one.flight.warnings), Contains(HasSubstr("the flight cannot tell")));
  const auto by_two = ValueOf(MoveToControl(flight.known, flight.Survey(2)));
  EXPECT_FALSE(by_two.is_by_hand);
  EXPECT_THAT(InWords(by_two.flight.warnings), Not(Contains(HasSubstr("placed by hand now"))));
  EXPECT_THAT(InWords(by_two.flight.warnings), Not(Contains(HasSubstr("the flight cannot tell"))));
}

struct Shifted : Displaced {
  Shifted() : Displaced({0.01, 1.01, {3.0, -2.0}}) {
    known.is_placed = true;
    known.align_report.emplace();
  }
};

struct Adrift : Displaced {
  Adrift() : Displaced({2.1, 0.37, {12.0, -7.0}}) {
    known.flight.frame = geo::LocalFrame({0.0, 0.0, 0.0});
    known.is_placed = false;
    known.align_report.emplace();
  }
};

std::ptrdiff_t CountOf(const std::vector<std::string>& warnings, const std::string& begin) {
  return std::count_if(warnings.begin(), warnings.end(),
                       [&](const std::string& text) { return text.starts_with(begin); });
}

TEST(PlaceByLists, MovesAMapThatHasItsPlaceByFewPointsAndPlacesItByMany) {
  const Shifted flight;
  for (const std::size_t points : {2u, 3u, 5u}) {
    const auto placed = ValueOf(PlaceByLists(flight.known, flight.Survey(points)));
    EXPECT_TRUE(placed.is_placed);
    EXPECT_EQ(placed.align_report->control.size(), points);
    const geo::Wgs84 said =
        placed.flight.frame.Wgs84FromEnu(placed.flight.photos[0].cam_from_enu.TargetOriginInSource());
    EXPECT_LT((flight.truth.frame.EnuFromWgs84(said) -
               flight.truth.photos[0].pose.cam_from_enu.TargetOriginInSource())
                  .head<2>()
                  .norm(),
              0.1)
        << points;
  }
}

TEST(PlaceByLists, SaysWhatIsSoNowAndNotWhatWasSoBefore) {
  const Shifted flight;
  const auto once = ValueOf(PlaceByLists(flight.known, flight.Survey(5, {25.0, -18.0, 0.0})));
  EXPECT_THAT(InWords(once.flight.warnings), Contains(StartsWith("Ground control point point0 is not used")));
  const auto again = ValueOf(PlaceByLists(once, flight.Survey(5)));
  EXPECT_EQ(CountOf(InWords(again.flight.warnings), "Ground control point "), 0);
  EXPECT_EQ(CountOf(InWords(again.flight.warnings), "The finished map was placed by 5 surveyed points"), 1);
}

TEST(PlaceByLists, NamesTwoPointsThatContradictEachOther) {
  Shifted flight;
  std::vector<flight::GcpList> lists = flight.Survey(2);
  std::swap(lists[0].points[0].position, lists[0].points[1].position);
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, lists)).message, HasSubstr("contradict each other"));
  flight.known.is_by_hand = true;  // its scale and north may be guesses
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, lists)).message, HasSubstr("are needed"));
}

TEST(PlaceByLists, LeavesAMapWhereItIsForCheckPointsAlone) {
  Shifted flight;
  std::vector<flight::GcpList> checks = flight.Survey(3);
  for (flight::GcpPoint& point : checks[0].points) point.name += "_check";
  auto compared = ValueOf(PlaceByLists(flight.known, checks));
  TellMarks(checks, compared);
  EXPECT_TRUE(compared.appearance) << "nothing is to be drawn";
  EXPECT_EQ(flight.WorstCameraM(compared), flight.WorstCameraM(flight.known));
  ASSERT_EQ(compared.align_report->control.size(), 3u);
  for (const alignment::ControlReport& point : compared.align_report->control)
    EXPECT_TRUE(point.is_used && point.is_check) << point.name;
  // Points that placed it tell nothing of how far off it is.
  const auto by_points = ValueOf(PlaceByLists(flight.known, flight.Survey(3)));
  EXPECT_THAT(ErrorOf(PlaceByLists(by_points, checks)).message, HasSubstr("check points alone"));
  flight.known.align_report.reset();  // of poses alone, which show no point where it is
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, checks)).message, HasSubstr("check points alone"));
}

// Of a flight by its log this is all that is left of where its records had it.
TEST(PlaceByLists, AddsUpHowFarPointsMovedTheMap) {
  const Shifted flight;
  const auto way_m = [](const Result<FlightFacts>& placed) {
    return Eigen::Vector2d(placed->align_report->position_bias_m.head<2>());
  };
  const auto by_few = PlaceByLists(flight.known, flight.Survey(3));
  ASSERT_TRUE(by_few.ok());
  EXPECT_GT(way_m(by_few).norm(), 0.5);
  const auto again = PlaceByLists(*by_few, flight.Survey(5));
  ASSERT_TRUE(again.ok());
  EXPECT_LT((way_m(again) - way_m(by_few)).norm(), 0.1);
}

TEST(PlaceByLists, PlacesAMapThatLiesNowhereByThreePoints) {
  const Adrift flight;
  EXPECT_TRUE(ValueOf(PlaceByLists(flight.known, flight.Survey(3))).is_placed);
  bool contradict = false;
  EXPECT_EQ(ErrorOf(PlaceByLists(flight.known, flight.Survey(2), &contradict)).code,
            ErrorCode::kUnprocessable);
  EXPECT_FALSE(contradict);
  auto unmarked = flight.Survey(3);
  unmarked.front().sightings.clear();
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, unmarked)).message,
              HasSubstr("No surveyed point is marked"));
}

TEST(TellMarks, SaysHowFarEachMarkLiesOffAndWhichIsContradicted) {
  const Adrift flight;
  auto lists = flight.Survey(4);
  // One mark far off, one a little.
  flight::GcpSighting& far_off = lists.front().sightings[0];
  far_off.pixel_x += far_off.pixel_x > 400.0 ? -300.0 : 300.0;
  flight::GcpSighting* little = nullptr;
  for (flight::GcpSighting& sighting : lists.front().sightings) {
    if (sighting.point == 1) little = &sighting;
  }
  ASSERT_NE(little, nullptr);
  little->pixel_y += little->pixel_y > 300.0 ? -3.0 : 3.0;
  auto placed = ValueOf(PlaceByLists(flight.known, lists));
  TellMarks(lists, placed);
  const auto& points = placed.align_report->control;
  ASSERT_EQ(points.size(), 4u);
  const auto mark = [&](std::size_t point, const std::string& photo) {
    for (const alignment::ControlMarkReport& one : points[point].marks) {
      if (one.photo == photo) return one;
    }
    ADD_FAILURE() << photo;
    return alignment::ControlMarkReport();
  };
  const auto wrong = mark(0, far_off.image_name);
  EXPECT_FALSE(wrong.is_used);
  EXPECT_NEAR(wrong.residual_px, 300.0, 10.0);
  EXPECT_GT(wrong.residual_m, 0.0);
  const auto small = mark(1, little->image_name);
  EXPECT_TRUE(small.is_used);
  EXPECT_GT(small.residual_px, 1.0);
  for (const alignment::ControlMarkReport& one : points[2].marks) EXPECT_LT(one.residual_px, 1.5);
  // Of a map without a place the marks would tell nonsense.
  FlightFacts nowhere = flight.known;
  nowhere.align_report->control = points;
  for (auto& point : nowhere.align_report->control) point.marks.clear();
  TellMarks(lists, nowhere);
  EXPECT_TRUE(nowhere.align_report->control[0].marks.empty());
}

// Surveys count from the sea, satellites from the ellipsoid: the map keeps its zero, and says the other.
TEST(TellMarks, SaysHowFarTheSurveyCountsItsHeightsFromTheRecordsZero) {
  const Shifted flight;
  constexpr double kGeoidM = 47.3;
  for (const std::size_t points : {1u, 3u, 5u}) {
    std::vector<flight::GcpList> lists = flight.Survey(points);
    for (auto& point : lists.front().points) *point.height_m -= kGeoidM;
    auto placed = ValueOf(PlaceByLists(flight.known, lists));
    TellMarks(lists, placed);
    const std::optional<double>& above_m = placed.align_report->survey_above_records_m;
    ASSERT_TRUE(above_m) << points;
    const auto height_m = [](const geo::LocalFrame& frame, const geo::Rigid3& cam_from_enu) {
      return frame.Wgs84FromEnu(cam_from_enu.TargetOriginInSource()).height_ellipsoid_m;
    };
    EXPECT_NEAR(height_m(placed.flight.frame, placed.flight.photos[0].cam_from_enu) + *above_m,
                height_m(flight.truth.frame, flight.truth.photos[0].pose.cam_from_enu) - kGeoidM, 1.0)
        << points;

    const double was_m = *above_m;
    for (std::size_t k = 0; points == 5 && k < 3; ++k) lists.front().points[k].height_m = 0.0;
    TellMarks(lists, placed);
    EXPECT_NEAR(above_m.value_or(0.0), was_m, 0.1) << "heights of 0 were not filled in";

    for (auto& point : lists.front().points) point.height_m.reset();
    TellMarks(lists, placed);
    EXPECT_FALSE(above_m) << points;
  }
}

TEST(TellMarks, ComparesCheckPointsWithTheMapWhichTheyDoNotMove) {
  const Shifted flight;
  std::vector<flight::GcpList> lists = flight.Survey(5, {0.5, 0.0, 0.0});
  lists[0].points[0].name = "point0_check";
  auto placed = ValueOf(PlaceByLists(flight.known, lists));
  EXPECT_LT(flight.WorstCameraM(placed), 0.05);
  for (int again = 0; again < 2; ++again) {
    TellMarks(lists, placed);
    const auto& told = placed.align_report->control;
    ASSERT_EQ(told.size(), 5u);
    EXPECT_TRUE(told.back().is_check);
    EXPECT_NEAR(told.back().miss_east_m, -0.5, 0.05);
    EXPECT_TRUE(std::isnan(told.back().miss_up_m)) << "not compared";
    EXPECT_GE(told.back().marks.size(), 2u);
    EXPECT_FALSE(told.front().is_check);
    const auto& warnings = placed.flight.warnings;
    EXPECT_EQ(std::count_if(
                  warnings.begin(), warnings.end(),
                  [](const flight::Remark& said) { return said.code == flight::RemarkCode::kCheckFarOff; }),
              1);
  }
}

// As of "skyquilt place --gcp", whose list is none of the flight's.
TEST(TellMarks, KeepsWhatWasToldOfPointsThatNoneOfTheListsHas) {
  const Adrift flight;
  PlaceRequest request;
  request.control = flight.Survey(5);
  request.control[0].points[4].name = "point4_check";
  auto placed = ValueOf(PlaceKnown(flight.known, request));
  TellMarks(request.control, placed);
  std::vector<flight::GcpList> own = flight.Survey(1);
  own[0].points[0].name = "own_check";
  for (std::size_t of_own = 0; of_own < 2; ++of_own) {
    if (of_own == 0)
      TellMarks({}, placed);
    else
      TellMarks(own, placed);
    const auto& told = placed.align_report->control;
    ASSERT_EQ(told.size(), 5u + of_own);
    EXPECT_TRUE(told[4].is_check);
    EXPECT_EQ(told[4].name, "point4_check");
    for (const alignment::ControlReport& point : told) EXPECT_GE(point.marks.size(), 2u) << point.name;
    EXPECT_TRUE(placed.align_report->survey_above_records_m) << "its heights are the survey's";
  }
}

TEST(TellMarks, TellsPointsOfOneNameApartByTheirPlaces) {
  const Shifted flight;
  std::vector<flight::GcpList> lists = flight.Survey(3);
  lists[0].points[1].name = lists[0].points[0].name;
  auto placed = ValueOf(PlaceByLists(flight.known, lists));
  TellMarks(lists, placed);
  const auto& told = placed.align_report->control;
  ASSERT_EQ(told.size(), 3u);
  for (const alignment::ControlReport& point : told)
    EXPECT_EQ(point.marks.size(), static_cast<std::size_t>(point.sightings));
  EXPECT_FALSE(told[0].marks == told[1].marks) << "they are in other places, of other photos";
}

// As the map is limited for them (judge_map): it is not said to be ready and not to be trusted there.
TEST(TellMarks, NamesNoCheckPointThatIsMissedByLessThanTheControlPointsLeaveOpen) {
  const Shifted flight;
  std::vector<flight::GcpList> lists = flight.Survey(5, {0.5, 0.0, 0.0});
  lists[0].points[0].name = "point0_check";
  auto placed = ValueOf(PlaceByLists(flight.known, lists));
  const auto are_named = [&] {
    TellMarks(lists, placed);
    const auto& warnings = placed.flight.warnings;
    return std::any_of(warnings.begin(), warnings.end(), [](const flight::Remark& said) {
      return said.code == flight::RemarkCode::kCheckFarOff;
    });
  };
  EXPECT_TRUE(are_named());
  double miss_m = 0.5;
  for (alignment::ControlReport& point : placed.align_report->control) {
    if (point.is_check) continue;
    point.miss_east_m = miss_m;
    point.left_out.reset();
    miss_m = -miss_m;
  }
  EXPECT_FALSE(are_named());
}

TEST(TellMarks, SaysFirstThatPointsContradictThePositions) {
  Shifted flight;
  const std::vector<flight::GcpList> lists = flight.Survey(4);
  for (alignment::AlignedPhoto& photo : flight.known.flight.photos) {
    ASSERT_TRUE(photo.photo.position);
    photo.photo.position->position.lat_deg += 60.0 / 111'200.0;
  }
  auto placed = ValueOf(PlaceByLists(flight.known, lists));
  for (int again = 0; again < 2; ++again) {
    TellMarks(lists, placed);
    const auto& warnings = placed.flight.warnings;
    ASSERT_FALSE(warnings.empty());
    EXPECT_EQ(warnings.front().code, flight::RemarkCode::kControlContradictsRecords);
    EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                            [](const flight::Remark& said) {
                              return said.code == flight::RemarkCode::kControlContradictsRecords;
                            }),
              1);
  }
  for (alignment::AlignedPhoto& photo : flight.known.flight.photos)
    photo.photo.position->position.lat_deg += 5'000.0 / 111'200.0;
  EXPECT_THAT(ErrorOf(PlaceByLists(flight.known, lists)).message, HasSubstr("gcp_list.txt is not used"));
}

}  // namespace
}  // namespace skyquilt::pipeline
