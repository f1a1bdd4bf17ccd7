// A finished flight brought to the surveyed points among its files, again and again; and what is told of
// marks.
#include "core/pipeline/placing/place_by_lists.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/flight/remarks/remark_words.h"
#include "tests/core/pipeline/displaced_flight.h"

namespace skyquilt::pipeline {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::StartsWith;

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
    const auto placed = PlaceByLists(flight.known, flight.Survey(points));
    ASSERT_TRUE(placed.ok()) << placed.error().message;
    EXPECT_TRUE(placed->is_placed);
    EXPECT_EQ(placed->align_report->control.size(), points);
    const geo::Wgs84 said =
        placed->flight.frame.Wgs84FromEnu(placed->flight.photos[0].cam_from_enu.TargetOriginInSource());
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
  const auto once = PlaceByLists(flight.known, flight.Survey(5, {25.0, -18.0, 0.0}));
  ASSERT_TRUE(once.ok());
  EXPECT_THAT(InWords(once->flight.warnings),
              Contains(StartsWith("Ground control point point0 is not used")));
  const auto again = PlaceByLists(*once, flight.Survey(5));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(CountOf(InWords(again->flight.warnings), "Ground control point "), 0);
  EXPECT_EQ(CountOf(InWords(again->flight.warnings), "The finished map was placed by 5 surveyed points"), 1);
}

TEST(PlaceByLists, PlacesAMapThatLiesNowhereByThreePoints) {
  const Adrift flight;
  const auto placed = PlaceByLists(flight.known, flight.Survey(3));
  ASSERT_TRUE(placed.ok()) << placed.error().message;
  EXPECT_TRUE(placed->is_placed);
  bool contradict = false;
  const auto too_few = PlaceByLists(flight.known, flight.Survey(2), &contradict);
  ASSERT_FALSE(too_few.ok());
  EXPECT_FALSE(contradict);
  EXPECT_EQ(too_few.error().code, ErrorCode::kUnprocessable);
  auto unmarked = flight.Survey(3);
  unmarked.front().sightings.clear();
  const auto none = PlaceByLists(flight.known, unmarked);
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(none.error().message, HasSubstr("No surveyed point is marked"));
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
  auto placed = PlaceByLists(flight.known, lists);
  ASSERT_TRUE(placed.ok()) << placed.error().message;
  TellMarks(lists, *placed);
  const auto& points = placed->align_report->control;
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

TEST(TellMarks, ComparesCheckPointsWithTheMapWhichTheyDoNotMove) {
  const Shifted flight;
  std::vector<flight::GcpList> lists = flight.Survey(5, {0.5, 0.0, 0.0});
  lists[0].points[0].name = "point0_check";
  Result<FlightFacts> placed = PlaceByLists(flight.known, lists);
  ASSERT_TRUE(placed);
  EXPECT_LT(flight.WorstCameraM(*placed), 0.05);
  for (int again = 0; again < 2; ++again) {
    TellMarks(lists, *placed);
    const auto& told = placed->align_report->control;
    ASSERT_EQ(told.size(), 5u);
    EXPECT_TRUE(told.back().is_check);
    EXPECT_NEAR(told.back().miss_east_m, -0.5, 0.05);
    EXPECT_GE(told.back().marks.size(), 2u);
    EXPECT_FALSE(told.front().is_check);
  }
}

}  // namespace
}  // namespace skyquilt::pipeline
