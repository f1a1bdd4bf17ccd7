// What supports a map's accuracy, and that over many simulated flights the stated one sigma is one.
#include "core/pipeline/report/judge_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/alignment/scene/ground_control.h"
#include "core/pipeline/inspect_flight.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Photos on a grid, aligned where the best move of the recorded positions puts them, as alignment does.
struct JudgedFlight {
  alignment::AlignedFlight flight;
  poses::PoseReport poses;
  alignment::AlignReport report;

  explicit JudgedFlight(int photos) {
    flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
    report.tie_points = 1000;
    report.residual_rms_px = 0.5;
    for (int i = 0; i < photos; ++i) {
      alignment::AlignedPhoto photo;
      photo.photo.name = "p" + std::to_string(i);
      photo.placement = alignment::Placement::kAligned;
      photo.error_radius_m = 9.0;
      flight.photos.push_back(photo);
      Stand(static_cast<std::size_t>(i), {20.0 * (i % 6), 20.0 * (i / 6)});
      Record(static_cast<std::size_t>(i), {20.0 * (i % 6), 20.0 * (i / 6)});
    }
  }

  void Stand(std::size_t i, const Vector2d& place) {
    flight.photos[i].cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(),
                                                                             {place.x(), place.y(), 60.0});
  }
  void Record(std::size_t i, const Vector2d& place) {
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu({place.x(), place.y(), 60.0});
    flight.photos[i].photo.position.emplace().position = {at.lat_deg, at.lon_deg};
  }
  void Refute(std::size_t i) {
    alignment::AlignPhotoReport& refuted = report.photo_reports.emplace_back();
    refuted.name = "p" + std::to_string(i);
    refuted.faults = {alignment::PhotoFault::kPositionWrong};
  }
  // Recorded as far off where it stands as the pictures do not believe.
  void Misplace(std::size_t i, const Vector2d& by) {
    Record(i, Vector2d(flight.photos[i].cam_from_enu.TargetOriginInSource().head<2>()) + by);
    Refute(i);
  }
  void Surveyed(bool is_check, double east_m, double north_m, bool is_predicted = false) {
    alignment::ControlReport point;
    point.is_used = true;
    point.is_check = is_check;
    // Spread as the photos are: the first five stand at four corners and the middle.
    const std::array<Vector2d, 5> places = {
        {{50.0, 20.0}, {0.0, 0.0}, {100.0, 0.0}, {0.0, 40.0}, {100.0, 40.0}}};
    const Vector2d& place = places[report.control.size() % places.size()];
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu({place.x(), place.y(), 0.0});
    point.surveyed = {at.lat_deg, at.lon_deg};
    point.sightings = 4;
    point.miss_east_m = east_m;
    point.miss_north_m = north_m;
    if (is_predicted) point.left_out = alignment::ControlPrediction{east_m, north_m, 0.0};
    report.control.push_back(point);
  }
  JudgedMap Map() const { return {.flight = flight, .poses = poses, .alignment = &report, .gsd_m = 0.02}; }
  MapQuality Judge() const { return JudgeMap(Map()); }
};

TEST(JudgeMap, StatesWhatThePositionsShareWhereTheyAgree) {
  JudgedFlight flight(18);
  const MapQuality plain = flight.Judge();
  EXPECT_EQ(plain.absolute, (AbsoluteAccuracy{2.3, AbsoluteSupport::kGnss, 18}));  // 1.515 x 1.5 m
  EXPECT_EQ(plain.relative, (RelativeAccuracy{0.01, 0.5, RelativeSupport::kTiePoints, 1000}));
  EXPECT_EQ(plain.status, MapStatus::kReady);
  for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = true;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 18}));
}

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

TEST(JudgeMap, ByRecordsAloneEachPhotoIsAsFarOffAsItSays) {
  JudgedFlight flight(5);
  for (auto& photo : flight.flight.photos) photo.placement = alignment::Placement::kPoseOnly;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{9.0, AbsoluteSupport::kGnss, 5}));
  EXPECT_FALSE(quality.IsLimitedBy(LimitKind::kFewPositions)) << "all five have one";
  EXPECT_EQ(quality.status, MapStatus::kLimited);
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

TEST(JudgeMap, NeverCallsUsableWhatAHandfulOfPhotosPlaces) {
  for (const std::size_t with : {1u, 2u, 3u, 4u, 5u}) {
    JudgedFlight flight(42);
    for (std::size_t i = with; i < 42; ++i) flight.flight.photos[i].photo.position.reset();
    JudgedMap map = flight.Map();
    map.is_by_images = true;
    const MapQuality quality = JudgeMap(map);
    EXPECT_EQ(quality.status, MapStatus::kDoubtful) << with;
    EXPECT_FALSE(quality.absolute.sigma_m);
    ASSERT_TRUE(quality.IsLimitedBy(LimitKind::kFewPositions));
    EXPECT_EQ(quality.limits.back(), (MapLimit{LimitKind::kFewPositions, static_cast<int>(with), 42}));
    EXPECT_EQ(quality.IsLimitedBy(LimitKind::kScaleGuessed), with == 1);
  }
  const auto placed_by = [](std::size_t with, int photos) {
    JudgedFlight flight(photos);
    for (std::size_t i = with; i < flight.flight.photos.size(); ++i)
      flight.flight.photos[i].photo.position.reset();
    return flight.Judge().status;
  };
  EXPECT_EQ(placed_by(6, 42), MapStatus::kReady);
  EXPECT_EQ(placed_by(6, 61), MapStatus::kDoubtful) << "fewer than a tenth";
  EXPECT_EQ(placed_by(4, 8), MapStatus::kReady) << "half of them";
  EXPECT_EQ(placed_by(4, 9), MapStatus::kDoubtful);
  EXPECT_EQ(placed_by(2, 4), MapStatus::kDoubtful) << "turn and scale";
  JudgedFlight half(42);
  for (std::size_t i = 21; i < 42; ++i) half.flight.photos[i].photo.position.reset();
  EXPECT_EQ(half.Judge().status, MapStatus::kReady);
  EXPECT_EQ(JudgedFlight(1).Judge().status, MapStatus::kReady) << "its own position places a single photo";
}

TEST(JudgeMap, LetsARefutedPositionPlaceNothing) {
  JudgedFlight flight(18);
  flight.Record(3, {5000.0, 0.0});
  EXPECT_GT(*flight.Judge().absolute.sigma_m, 10.0);
  flight.Refute(3);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{2.3, AbsoluteSupport::kGnss, 17}));
}

TEST(JudgeMap, DoubtsAMapOfWhichEveryPositionIsRefuted) {
  JudgedFlight flight(2);
  for (const std::size_t i : {0u, 1u}) flight.Refute(i);
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, AbsoluteAccuracy());
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kFewPositions, 0, 2}}));
}

TEST(JudgeMap, CountsAFixThatPhotosRepeatOnce) {
  JudgedFlight flight(12);
  for (std::size_t i = 0; i < 12; ++i) flight.flight.photos[i].photo.position->is_repeated = i % 3 != 0;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kGnss, 4}));
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
}

// Of a picture that was cut: the lines flown one way refute those flown the other, all by the same way.
TEST(JudgeMap, IsNoBetterThanTheManyPositionsThatItRefutes) {
  JudgedFlight flight(12);
  for (std::size_t i = 5; i < 10; ++i) flight.Misplace(i, {0.0, 15.0});
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{12.0, AbsoluteSupport::kGnss, 7}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
  EXPECT_EQ(quality.limits,
            (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}, {LimitKind::kFarOff}}));
}

TEST(JudgeMap, SuspectsAFewRefutedPositionsOnlyWhereTheyAgree) {
  JudgedFlight alike(18), each_its_own(18);
  const std::array<Vector2d, 3> ways = {{{15.0, 0.0}, {-15.0, 0.0}, {0.0, 15.0}}};
  for (std::size_t i = 0; i < ways.size(); ++i) {
    alike.Misplace(i, ways[0]);
    each_its_own.Misplace(i, ways[i]);
  }
  EXPECT_TRUE(alike.Judge().IsLimitedBy(LimitKind::kPositionsContradicted));
  EXPECT_GT(*alike.Judge().absolute.sigma_m, 5.0);
  EXPECT_EQ(each_its_own.Judge().absolute, (AbsoluteAccuracy{2.3, AbsoluteSupport::kGnss, 15}));
  EXPECT_EQ(each_its_own.Judge().status, MapStatus::kReady);
}

// Records of another continent say nothing of how far off this map is.
TEST(JudgeMap, TakesNoRefutedPositionForFurtherOffThanTheMapIsLong) {
  JudgedFlight flight(12);
  for (std::size_t i = 5; i < 10; ++i) flight.Misplace(i, {0.0, 9000.0});
  EXPECT_TRUE(flight.Judge().IsLimitedBy(LimitKind::kPositionsContradicted));
  EXPECT_LT(*flight.Judge().absolute.sigma_m, 110.0);
}

TEST(JudgeMap, IsNoBetterThanTheWarningOfContradictedPositionsSays) {
  using flight::Remark;
  using flight::RemarkCode;
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = true;
  flight.flight.warnings = {
      {RemarkCode::kPositionsContradict, {{"photos", 18}, {"apart_m", 0.22}, {"times", 11.0}}}};
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{0.22, AbsoluteSupport::kRtk, 18}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}}));
  // Among what is said of a flight that its pictures place: the map lies where most positions have it.
  const Remark against{RemarkCode::kImagesAgainstPositions, {{"apart_m", 0.22}, {"times", 11.0}}};
  const Remark outcome{RemarkCode::kImagesPlaced, {{"photos", 18}, {"total", 18}, {"place", against}}};
  flight.flight.warnings = {{RemarkCode::kPlacedByImages, {{"why", "asked"}, {"outcome", outcome}}}};
  EXPECT_EQ(flight.Judge().absolute.sigma_m, 0.03);
  EXPECT_TRUE(flight.Judge().IsLimitedBy(LimitKind::kPositionsContradicted));
  flight.Surveyed(true, 0.3, 0.4);
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady) << "a check point says how far off it is";
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
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.5, AbsoluteSupport::kCheckPoints, 1}));
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

TEST(JudgeMap, OfAMapThatWasPlacedByHandSaysNothing) {
  const JudgedFlight flight(18);
  JudgedMap map = flight.Map();
  map.is_by_hand = true;
  const MapQuality quality = JudgeMap(map);
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kHand, 0}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
}

TEST(JudgeMap, TakesALogsPositionsForThePhotosOfTheLog) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position.reset();
  flight.poses.photos_by_log = 18;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{9.0, AbsoluteSupport::kHand, 18}));
  flight.poses.log_position_sigma_m = 0.02;
  flight.poses.log_is_corrected = true;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 18}));
}

TEST(JudgeMap, IsNotReadyWhereAListContradictsThePhotosOwnPositions) {
  JudgedFlight flight(18);
  flight.poses.lists_contradict_m = 14.0;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{21.0, AbsoluteSupport::kGnss, 18}));  // 1.515 x 14 m
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kFarOff}}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
}

TEST(JudgeMap, DoubtsAMapWhosePhotosMayLieElsewhereOnTheTrack) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position.reset();
  flight.poses.photos_by_log = 18;
  flight.poses.log_position_sigma_m = 1.5;
  flight.poses.time_sigma_s = 2.0;
  EXPECT_NE(flight.Judge().status, MapStatus::kDoubtful);
  flight.poses.time_sigma_s = poses::kOpenClockSigmaS;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kGnss, 0}));
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

// Recorded places with noise and a common error; the map is moved, turned and scaled to fit them best.
double CoveredShare(double noise_m, double common_m, bool is_corrected, int photos) {
  constexpr int kFlights = 400;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int covered = 0;
  for (int run = 0; run < kFlights; ++run) {
    JudgedFlight flight(photos);
    const Vector2d common(common_m * normal(random), common_m * normal(random));
    Eigen::MatrixXd design(2 * photos, 4);
    Eigen::VectorXd off(2 * photos);
    std::vector<Vector2d> truth, recorded;
    for (int i = 0; i < photos; ++i) {
      const Vector3d place =
          flight.flight.photos[static_cast<std::size_t>(i)].cam_from_enu.TargetOriginInSource();
      truth.emplace_back(place.head<2>());
      const Vector2d error = common + noise_m * Vector2d(normal(random), normal(random));
      recorded.emplace_back(truth.back() + error);
      design.row(2 * i) << 1.0, 0.0, place.x(), -place.y();
      design.row(2 * i + 1) << 0.0, 1.0, place.y(), place.x();
      off.segment<2>(2 * i) = error;
    }
    const Eigen::VectorXd moved =
        design * (design.transpose() * design).ldlt().solve(design.transpose() * off);
    for (int i = 0; i < photos; ++i) {
      const auto photo = static_cast<std::size_t>(i);
      flight.Stand(photo, truth[photo] + moved.segment<2>(2 * i));
      flight.Record(photo, recorded[photo]);
      flight.flight.photos[photo].photo.position->is_rtk_fixed = is_corrected;
    }
    const double sigma_m = *flight.Judge().absolute.sigma_m;
    const Eigen::Index any = 2 * static_cast<Eigen::Index>(random() % static_cast<unsigned>(photos));
    covered += moved.segment<2>(any).norm() <= sigma_m ? 1 : 0;
  }
  return static_cast<double>(covered) / kFlights;
}

TEST(JudgeMap, CoversTwoThirdsOfTheErrorsWhereTheCommonErrorIsAsAssumed) {
  for (const int photos : {9, 24, 60}) {
    for (const auto& [noise_m, is_corrected] : {std::pair{0.02, true}, {1.0, false}, {3.0, false}}) {
      const double share = CoveredShare(noise_m, is_corrected ? 0.02 : 1.5, is_corrected, photos);
      EXPECT_GT(share, 0.62) << noise_m << " m, " << photos << " photos";
      EXPECT_LT(share, 0.75) << noise_m << " m, " << photos << " photos";
    }
  }
}

TEST(JudgeMap, CoversMoreWithoutTheAssumedCommonError) { EXPECT_GT(CoveredShare(1.0, 0.0, false, 24), 0.95); }

}  // namespace
}  // namespace skyquilt::pipeline
