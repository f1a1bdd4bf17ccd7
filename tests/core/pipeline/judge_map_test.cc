// What supports a map's accuracy, and what limits it.
#include "core/pipeline/report/judge_map.h"

#include <gtest/gtest.h>

#include <cstddef>

#include "core/flight/aside/aside.h"
#include "core/pipeline/inspect_flight.h"
#include "tests/core/pipeline/judged_flight.h"

namespace skyquilt::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(JudgeMap, IsForetoldAsItTurnsOutWhereThePositionsAgree) {
  const JudgedFlight flight(18);
  alignment::AlignedFlight recorded = flight.flight;
  for (auto& photo : recorded.photos) photo.placement = alignment::Placement::kPoseOnly;
  EXPECT_EQ(JudgeMap({.flight = recorded, .poses = flight.poses, .is_forecast = true}).absolute,
            flight.Judge().absolute);
}

TEST(ForeseenStatus, IsWhatTheRecordsDecideAlone) {
  FlightVerdict verdict;
  EXPECT_FALSE(ForeseenStatus(verdict)) << "there is no map";
  verdict.photos_placeable = 18;
  const auto judge = [&](const JudgedFlight& flight) {
    verdict.by_records = JudgeMap({.flight = flight.flight, .poses = flight.poses, .is_forecast = true});
    return ForeseenStatus(verdict);
  };
  JudgedFlight flight(18);
  EXPECT_FALSE(judge(flight)) << "the photos may contradict the records";
  for (const char* said : {"Records     +-2.3 m (1 sigma), by 18 positions of GNSS: what they claim",
                           "Status      and accuracy come with the map"})
    EXPECT_NE(VerdictText(verdict).find(said), std::string::npos) << VerdictText(verdict);
  EXPECT_EQ(VerdictText(verdict).find("Accuracy"), std::string::npos);
  EXPECT_NE(VerdictJson(verdict).find("\"status\": null"), std::string::npos);
  for (std::size_t i = 1; i < 18; ++i) flight.flight.photos[i].photo.position.reset();
  EXPECT_EQ(judge(flight), MapStatus::kDoubtful);
  EXPECT_NE(VerdictText(verdict).find("Status      Place in doubt. Only 1 of 18 photos"), std::string::npos);
  verdict.gcp_lists = {"gcp_list.txt: 5 points, 23 sightings"};
  EXPECT_FALSE(ForeseenStatus(verdict)) << "surveyed points may place it";
}

TEST(VerdictText, SaysNoOverlapWherePhotosHaveNoNextOne) {
  FlightVerdict verdict;
  verdict.photos_placeable = 1;
  EXPECT_EQ(VerdictText(verdict).find("overlap"), std::string::npos) << VerdictText(verdict);
  EXPECT_NE(VerdictJson(verdict).find("\"forward_overlap\": null"), std::string::npos);
  verdict.forward_overlap = 0.754;
  EXPECT_NE(VerdictText(verdict).find(", 75 % forward overlap, "), std::string::npos) << VerdictText(verdict);
}

TEST(JudgeMap, SaysNoNumberWithoutPositions) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position.reset();
  JudgedMap map = flight.Map();
  map.is_placed = false;
  map.is_by_images = true;
  const MapQuality quality = JudgeMap(map);
  EXPECT_EQ(quality.absolute, AbsoluteAccuracy());
  EXPECT_EQ(quality.status, MapStatus::kUnplaced);
  EXPECT_TRUE(quality.IsLimitedBy(LimitKind::kScaleGuessed));
  EXPECT_FALSE(quality.relative.error_m);
  EXPECT_EQ(quality.relative.error_px, 0.5);
  // Photos that a log without positions places by dead reckoning have their scale.
  map.is_by_images = false;
  EXPECT_FALSE(JudgeMap(map).IsLimitedBy(LimitKind::kScaleGuessed));
}

TEST(JudgeMap, DoubtsAMapWhoseNorthIsAGuessUntilTwoSurveyedPointsTieIt) {
  JudgedFlight flight(8);
  flight.report.by_images.is_taken = true;
  flight.report.by_images.is_north_guessed = true;
  const MapQuality quality = flight.Judge();
  EXPECT_FALSE(quality.absolute.sigma_m);
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kNorthGuessed}}));
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
  for (int k = 0; k < 2; ++k) flight.Surveyed(false, 0.0, 0.0);
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady);
}

TEST(JudgeMap, StatesNoNumberWhereTheScaleIsAGuess) {
  JudgedFlight by_images(8);
  by_images.report.by_images.is_taken = true;
  by_images.report.by_images.is_scale_guessed = true;
  JudgedFlight by_records(1);
  by_records.flight.photos[0].placement = alignment::Placement::kPoseOnly;
  by_records.poses.is_height_guessed = true;
  for (const JudgedFlight* flight : {&by_images, &by_records}) {
    const MapQuality quality = flight->Judge();
    EXPECT_FALSE(quality.absolute.sigma_m);
    EXPECT_TRUE(quality.IsLimitedBy(LimitKind::kScaleGuessed));
    EXPECT_FALSE(quality.relative.error_m);
    EXPECT_EQ(quality.status, MapStatus::kDoubtful);
  }
  JudgedFlight many(8);
  for (auto& photo : many.flight.photos) photo.placement = alignment::Placement::kPoseOnly;
  many.poses.is_height_guessed = true;
  EXPECT_FALSE(many.Judge().IsLimitedBy(LimitKind::kScaleGuessed)) << "eight places tell how large it is";
  by_images.Surveyed(false, 0.01, 0.0);
  by_images.Surveyed(false, 0.0, 0.01);
  EXPECT_FALSE(by_images.Judge().IsLimitedBy(LimitKind::kScaleGuessed)) << "surveyed points tell it";
  JudgedFlight aligned(8);
  aligned.poses.is_height_guessed = true;
  EXPECT_EQ(aligned.Judge().status, MapStatus::kReady) << "its positions tell the scale";
}

TEST(JudgeMap, BelievesCheckPointsFirstThenControlPointsThatFit) {
  JudgedFlight flight(18);
  flight.Surveyed(false, 0.0, 0.0);
  EXPECT_EQ(flight.Judge().absolute.by, AbsoluteSupport::kGnss)
      << "one point has nothing to be checked against";
  for (int i = 0; i < 4; ++i) flight.Surveyed(false, 0.01, -0.01, true);
  const AbsoluteAccuracy by_control = flight.Judge().absolute;
  EXPECT_EQ(by_control.by, AbsoluteSupport::kControlPoints);
  EXPECT_EQ(by_control.count, 5);
  // 1.515 x 0.0206 m (survey, marks) x sqrt(1/5 + how the photos spread against the points)
  EXPECT_NEAR(*by_control.sigma_m, 0.018, 0.002);
  flight.Surveyed(true, 0.3, 0.4);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.68, AbsoluteSupport::kCheckPoints, 1}));
}

TEST(JudgeMap, StatesNoLessOfCheckPointsThanSurveyAndMarksLeave) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = true;
  flight.Surveyed(true, 0.001, 0.0);
  // sqrt(2) x 0.0206 m, and one point knows little of a sigma: x 1.37
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.04, AbsoluteSupport::kCheckPoints, 1}));
  while (flight.report.control.size() < 30) flight.Surveyed(true, 0.001, 0.0);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.029, AbsoluteSupport::kCheckPoints, 30}));
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady);
}

TEST(JudgeMap, StatesMoreThanFewCheckPointsAreMissedBy) {
  JudgedFlight flight(18);
  for (int k = 0; k < 3; ++k) flight.Surveyed(true, 0.3, 0.4);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.55, AbsoluteSupport::kCheckPoints, 3}));
  for (int k = 0; k < 97; ++k) flight.Surveyed(true, 0.3, 0.4);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.5, AbsoluteSupport::kCheckPoints, 100}));
}

// One shows by how much the positions are off together, not how the map is turned and bent elsewhere.
TEST(JudgeMap, OfOneCheckPointStatesWhatPositionsLeaveOpenElsewhere) {
  JudgedFlight flight(18);
  for (std::size_t i = 0; i < 18; ++i) {
    const Vector2d stands = flight.flight.photos[i].cam_from_enu.TargetOriginInSource().head<2>();
    flight.Record(i, stands + Vector2d(0.0, i % 2 == 0 ? 2.0 : -2.0));
  }
  flight.Surveyed(true, 0.0, 0.01);
  EXPECT_NEAR(*flight.Judge().absolute.sigma_m, 0.76, 0.02);  // 1.515 x 1.5 m x sqrt(2/18)
  for (int k = 0; k < 2; ++k) flight.Surveyed(true, 0.0, 0.01);
  EXPECT_LT(*flight.Judge().absolute.sigma_m, 0.05) << "three, over all of it";
}

TEST(JudgeMap, KnowsNoMoreOfAMapThatAFewPositionsOrAHandPlacesByOneCheckPoint) {
  JudgedFlight flight(42);
  for (std::size_t i = 2; i < 42; ++i) flight.flight.photos[i].photo.position.reset();
  flight.Surveyed(true, 0.001, 0.0);
  EXPECT_FALSE(flight.Judge().absolute.sigma_m);
  EXPECT_EQ(flight.Judge().limits, (std::vector<MapLimit>{{LimitKind::kFewPositions, 2, 42}}));
  EXPECT_EQ(flight.Judge().status, MapStatus::kDoubtful);
  JudgedMap by_hand = flight.Map();
  by_hand.is_by_hand = true;
  EXPECT_EQ(JudgeMap(by_hand).absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kHand, 0}));
  for (int k = 0; k < 4; ++k) flight.Surveyed(true, 0.001, 0.0);
  EXPECT_EQ(flight.Judge().absolute.by, AbsoluteSupport::kCheckPoints) << "five, over all of it";
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady);
  EXPECT_EQ(JudgeMap(by_hand).absolute.by, AbsoluteSupport::kCheckPoints);
}

TEST(JudgeMap, IsLimitedWhereACheckPointIsMissedByMoreThanBothSidesErrBy) {
  const auto checked = [](bool is_corrected, int control, double miss_m) {
    JudgedFlight flight(18);
    for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = is_corrected;
    for (int k = 0; k < control; ++k) flight.Surveyed(false, 0.0, 0.0, true);
    flight.Surveyed(true, 0.0, miss_m);
    return flight.Judge();
  };
  EXPECT_EQ(checked(true, 0, 0.1).status, MapStatus::kReady);
  EXPECT_EQ(checked(false, 0, 3.0).status, MapStatus::kReady) << "which receivers err by";
  EXPECT_EQ(checked(false, 4, 0.1).status, MapStatus::kReady);
  const std::vector<MapLimit> missed = {{LimitKind::kChecksMissed, 1, 1}};
  for (const auto& quality : {checked(true, 0, 0.6), checked(true, 0, 5.0), checked(false, 4, 0.6)}) {
    EXPECT_EQ(quality.status, MapStatus::kLimited);
    EXPECT_EQ(quality.limits, missed);
  }
  EXPECT_TRUE(checked(false, 0, 9.0).IsLimitedBy(LimitKind::kChecksMissed));
}

// Marks and points are found in its photos, however coarse the map is drawn.
TEST(JudgeMap, StatesOfACoarseMapWhatItsPhotosTell) {
  JudgedFlight flight(18);
  JudgedMap coarse = flight.Map();
  coarse.gsd_m = 0.4;
  EXPECT_EQ(JudgeMap(coarse).relative.error_m, 0.01);  // half a pixel of 2 cm
  EXPECT_EQ(JudgeMap(coarse).relative.error_px, 0.025);
  for (int k = 0; k < 5; ++k) flight.Surveyed(false, 0.0, 0.0, true);
  EXPECT_EQ(JudgeMap(coarse).absolute, flight.Judge().absolute);
}

// What survey and marks do not explain is the map's own shape, and many points do not make it less.
TEST(JudgeMap, DoesNotAverageOutWhatControlPointsFindOfTheMapsShape) {
  JudgedFlight flight(18);
  for (int i = 0; i < 5; ++i) flight.Surveyed(false, 0.3, -0.4, true);
  const double of_five_m = *flight.Judge().absolute.sigma_m;
  EXPECT_NEAR(of_five_m, 0.54, 0.02);  // 1.515 x 0.5 m / sqrt(2)
  for (int i = 0; i < 45; ++i) flight.Surveyed(false, 0.3, -0.4, true);
  EXPECT_NEAR(*flight.Judge().absolute.sigma_m, of_five_m, 0.02);
}

// Two that stand together hold the map's middle, and hardly its turn and scale.
TEST(JudgeMap, StatesMoreWhereControlPointsSpanLittleOfTheMap) {
  JudgedFlight spread(18), together(18);
  for (int i = 0; i < 2; ++i) {
    spread.Surveyed(false, 0.0, 0.0);
    together.Surveyed(false, 0.0, 0.0);
  }
  const geo::Wgs84 beside = together.flight.frame.Wgs84FromEnu({52.0, 20.0, 0.0});
  together.report.control[1].surveyed = {beside.lat_deg, beside.lon_deg};
  EXPECT_GT(*together.Judge().absolute.sigma_m, 5.0 * *spread.Judge().absolute.sigma_m);
}

// The second of two points lies 10 m off: the map goes between them, and nothing says which is right.
TEST(JudgeMap, StatesWhatTwoControlPointsAreMissedBy) {
  JudgedFlight flight(18);
  flight.Surveyed(false, 5.0, 0.0);
  flight.Surveyed(false, -5.0, 0.0);
  EXPECT_NEAR(*flight.Judge().absolute.sigma_m, 7.6, 0.1);  // 1.515 x 5 m
}

TEST(JudgeMap, IsLimitedWhereControlPointsContradictThePositions) {
  const auto moved = [](double north_m, bool is_corrected, int control) {
    JudgedFlight flight(18);
    for (std::size_t i = 0; i < flight.flight.photos.size(); ++i) {
      const Vector3d camera = flight.flight.photos[i].cam_from_enu.TargetOriginInSource();
      flight.Record(i, camera.head<2>() + Vector2d(0.0, north_m));
      flight.flight.photos[i].photo.position->is_rtk_fixed = is_corrected;
    }
    for (int k = 0; k < control; ++k) flight.Surveyed(false, 0.0, 0.0, true);
    return flight.Judge();
  };
  EXPECT_EQ(moved(8.0, false, 4).status, MapStatus::kReady);
  EXPECT_EQ(moved(0.2, true, 4).status, MapStatus::kReady);
  for (const auto& quality : {moved(50.0, false, 4), moved(2.0, true, 4), moved(50.0, false, 1)}) {
    EXPECT_EQ(quality.status, MapStatus::kLimited);
    EXPECT_TRUE(quality.IsLimitedBy(LimitKind::kControlContradicted));
  }
  EXPECT_FALSE(moved(50.0, false, 0).IsLimitedBy(LimitKind::kControlContradicted)) << "no point places it";
  JudgedFlight by_log(18);
  for (auto& photo : by_log.flight.photos) photo.photo.position.reset();
  by_log.poses.photos_by_log = 18;
  by_log.poses.log_position_sigma_m = 1.5;
  by_log.report.position_bias_m = {0.0, 60.0, 0.0};
  for (int k = 0; k < 4; ++k) by_log.Surveyed(false, 0.0, 0.0, true);
  EXPECT_TRUE(by_log.Judge().IsLimitedBy(LimitKind::kControlContradicted));
}

// All points of a list lie off by what their datum's place on Earth is not known to.
TEST(JudgeMap, AddsWhatTheSystemOfTheSurveyIsKnownTo) {
  JudgedFlight flight(18);
  for (int k = 0; k < 4; ++k) flight.Surveyed(false, 0.0, 0.0, true);
  EXPECT_LT(*flight.Judge().absolute.sigma_m, 0.1);
  for (auto& point : flight.report.control) point.system_error_m = 2.0;
  EXPECT_NEAR(*flight.Judge().absolute.sigma_m, 2.0, 0.01);
  flight.Surveyed(true, 0.03, 0.04);
  flight.report.control.back().system_error_m = 2.0;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{2.0, AbsoluteSupport::kCheckPoints, 1}));
}

// The photos of two fields, between which nothing is shared.
struct TwoFields : JudgedFlight {
  explicit TwoFields(std::size_t of_first) : JudgedFlight(18) {
    report.components = 2;
    for (std::size_t i = 1; i < flight.photos.size(); ++i) {
      if (i != of_first) Tie(i - 1, i);
    }
  }
  void Tie(std::size_t first, std::size_t second) {
    alignment::AlignPairReport& pair = report.pairs.emplace_back();
    pair.first = flight.photos[first].photo.name;
    pair.second = flight.photos[second].photo.name;
  }
};

TEST(JudgeMap, StatesOfAFieldWithoutSurveyedPointsWhatItsPositionsSay) {
  for (const bool are_checks : {false, true}) {
    TwoFields flight(9);
    for (int k = 0; k < 4; ++k) flight.Surveyed(are_checks, 0.01, 0.01, true);
    EXPECT_LT(*flight.Judge().absolute.sigma_m, 0.1) << "where they are marked is not known";
    for (alignment::ControlReport& point : flight.report.control)
      point.marks.push_back({.photo = "p3", .residual_px = 0.5, .residual_m = 0.01, .is_used = true});
    // 2.3 m hold 0.683 of one half: 1.4 m hold 0.365 of it, and all of the other.
    const AbsoluteAccuracy of_both = flight.Judge().absolute;
    EXPECT_NEAR(*of_both.sigma_m, 1.4, 0.11);
    EXPECT_EQ(of_both.by, AbsoluteSupport::kGnss);
    EXPECT_EQ(of_both.count, 9);
    flight.Tie(8, 9);
    EXPECT_LT(*flight.Judge().absolute.sigma_m, 0.1) << "one holds the other";
  }
  TwoFields small(15);
  for (int k = 0; k < 4; ++k) small.Surveyed(false, 0.01, 0.01, true);
  const double alone_m = *small.Judge().absolute.sigma_m;
  for (alignment::ControlReport& point : small.report.control)
    point.marks.push_back({.photo = "p3", .residual_px = 0.5, .residual_m = 0.01, .is_used = true});
  const AbsoluteAccuracy mostly = small.Judge().absolute;
  EXPECT_EQ(mostly.by, AbsoluteSupport::kControlPoints) << "most photos";
  EXPECT_GT(*mostly.sigma_m, alone_m);
  EXPECT_LT(*mostly.sigma_m, 2.0 * alone_m);
  for (std::size_t i = 15; i < 18; ++i) small.flight.photos[i].photo.position.reset();
  EXPECT_EQ(small.Judge().absolute.by, AbsoluteSupport::kControlPoints);
  EXPECT_GT(*small.Judge().absolute.sigma_m, alone_m);
}

// The map is said to be of two groups all the same, each where its positions say.
TEST(JudgeMap, TakesNothingLooseBetweenTwoFieldsForATieThatHoldsThem) {
  const auto surveyed = [](bool is_by_direct) {
    TwoFields flight(9);
    for (int k = 0; k < 4; ++k) flight.Surveyed(false, 0.01, 0.01, true);
    for (alignment::ControlReport& point : flight.report.control)
      point.marks.push_back({.photo = "p3", .residual_px = 0.5, .residual_m = 0.01, .is_used = true});
    flight.Tie(8, 9);
    flight.report.pairs.back().is_by_direct = is_by_direct;
    return flight;
  };
  EXPECT_EQ(surveyed(false).Judge().absolute.by, AbsoluteSupport::kControlPoints);
  const TwoFields alike = surveyed(true);
  EXPECT_EQ(alike.Judge().absolute.by, AbsoluteSupport::kGnss);
  EXPECT_GT(*alike.Judge().absolute.sigma_m, 1.0);
  TwoFields weak = surveyed(false);
  weak.flight.photos[9].placement = alignment::Placement::kPoseOnly;
  EXPECT_EQ(weak.Judge().absolute.by, AbsoluteSupport::kGnss);
  EXPECT_GT(*weak.Judge().absolute.sigma_m, 1.0);
}

TEST(JudgeMap, DoesNotTakeAFieldWithoutCorrectionsForOneThatHasThem) {
  TwoFields flight(10);
  for (std::size_t i = 0; i < 10; ++i) flight.flight.photos[i].photo.position->is_rtk_fixed = true;
  const AbsoluteAccuracy of_both = flight.Judge().absolute;
  EXPECT_NEAR(*of_both.sigma_m, 1.2, 0.11);
  EXPECT_EQ(of_both.by, AbsoluteSupport::kGnss);
  EXPECT_EQ(of_both.count, 8);
  flight.Tie(9, 10);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 18}));
}

TEST(JudgeMap, FearsGapsWherePhotosAreMissingNotWhereCopiesAre) {
  JudgedFlight flight(18);
  flight.flight.left_out = {flight::LeftAside("a.JPG", flight::Aside::kCopy, "p0"),
                            flight::LeftAside("b.JPG", flight::Aside::kThermal, "M3T", "M3T, wide"),
                            {"c.tif", ErrorCode::kUnprocessable, flight::RemarkCode::kLeftPanel}};
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady);
  flight.flight.left_out.push_back(
      {"d.JPG", ErrorCode::kNoPosition, flight::RemarkCode::kLeftWithoutPosition});
  EXPECT_EQ(flight.Judge().limits, (std::vector<MapLimit>{{LimitKind::kLeftOut, 1, 19}}));
}

TEST(JudgeMap, OfAMapThatWasPlacedByHandSaysNothing) {
  const JudgedFlight flight(18);
  JudgedMap map = flight.Map();
  map.is_by_hand = true;
  const MapQuality quality = JudgeMap(map);
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kHand, 0}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
}

TEST(JudgeMap, TellsPhotosWhatTheMapIsToldAndLeavesOthers) {
  JudgedFlight flight(18);
  flight.flight.photos[4].placement = alignment::Placement::kPoseOnly;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kPoseOnly, 1, 18}}));
  TellPhotos(quality, flight.flight);
  EXPECT_EQ(flight.flight.photos[0].error_radius_m, *quality.absolute.sigma_m);
  EXPECT_EQ(flight.flight.photos[4].error_radius_m, 9.0);
}

}  // namespace
}  // namespace skyquilt::pipeline
