// A finished flight that lies nowhere, brought to its place by surveyed points or by what a user knows of it;
// and what is refused, in words that tell what to do.
#include "core/pipeline/placing/place_known.h"

#include <gmock/gmock.h>

#include <cmath>

#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/placing/place_by_lists.h"
#include "core/pipeline/placing/recall_flight.h"
#include "core/pipeline/report/judge_map.h"
#include "tests/core/pipeline/displaced_flight.h"
#include "tests/support/facts_alone.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

using test::ValueOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

// As the images alone leave a flight: at 0, 0, in a scale and with a north of no meaning.
struct Nowhere : Displaced {
  Nowhere() : Displaced({2.1, 0.37, {12.0, -7.0}}) {
    known.flight.frame = geo::LocalFrame({0.0, 0.0, 0.0});
    known.is_placed = false;
    known.is_by_images = true;
    known.poses_report.method = "none";
    known.poses_report.is_placed = false;
    known.align_report.emplace().position_bias_m = {1.0, 2.0, 3.0};
    known.flight.warnings = {"3 photos are blurred.",
                             {flight::RemarkCode::kNotGeoreferenced, {{"width_m", 100.0}}},
                             "No records: 20 photos placed."};
  }

  PlaceRequest BySurvey(std::size_t points, const Eigen::Vector3d& first_off_by = {0, 0, 0}) const {
    PlaceRequest request;
    request.control = Survey(points, first_off_by);
    return request;
  }

  // Between where the cameras are now said to be and where they were, in metres on Earth.
  std::vector<Eigen::Vector3d> MissesOnEarthM(const FlightFacts& facts) const {
    std::vector<Eigen::Vector3d> misses_m;
    for (std::size_t i = 0; i < truth.photos.size(); ++i) {
      const geo::Wgs84 said =
          facts.flight.frame.Wgs84FromEnu(facts.flight.photos[i].cam_from_enu.TargetOriginInSource());
      misses_m.push_back(truth.frame.EnuFromWgs84(said) -
                         truth.photos[i].pose.cam_from_enu.TargetOriginInSource());
    }
    return misses_m;
  }
  double WorstOnEarthM(const FlightFacts& facts) const {
    double worst_m = 0.0;
    for (const Eigen::Vector3d& miss_m : MissesOnEarthM(facts)) worst_m = std::max(worst_m, miss_m.norm());
    return worst_m;
  }
  double WorstHorizontallyM(const FlightFacts& facts) const {
    double worst_m = 0.0;
    for (const Eigen::Vector3d& miss_m : MissesOnEarthM(facts))
      worst_m = std::max(worst_m, miss_m.head<2>().norm());
    return worst_m;
  }
};

std::string RefusalOf(const Result<FlightFacts>& placed) {
  EXPECT_FALSE(placed.ok());
  return placed.ok() ? "" : placed.error().message;
}

TEST(PlaceKnown, SurveyedPointsGivePlaceScaleAndNorth) {
  const Nowhere flight;
  for (const std::size_t points : {3u, 4u, 5u}) {
    const auto placed = ValueOf(PlaceKnown(flight.known, flight.BySurvey(points)));
    EXPECT_LT(flight.WorstOnEarthM(placed), 0.05) << points;
    EXPECT_LT(flight.WorstTurnRad(placed), 1e-3);
    EXPECT_TRUE(placed.is_placed);
    EXPECT_FALSE(placed.appearance);
    EXPECT_NEAR(placed.flight.photos[0].height_above_ground_m,
                flight.known.flight.photos[0].height_above_ground_m / 0.37, 0.1);
    EXPECT_LE(placed.flight.photos[0].error_radius_m, 0.05);
    EXPECT_TRUE(placed.poses_report.is_placed);
    EXPECT_EQ(placed.poses_report.method, "none");
    EXPECT_EQ(placed.align_report->control.size(), points);
    EXPECT_TRUE(placed.align_report->control[0].is_used);
    EXPECT_LT(std::abs(placed.align_report->control[0].miss_up_m), 0.1);
    EXPECT_EQ(placed.align_report->position_bias_m, Eigen::Vector3d::Zero());
    EXPECT_THAT(InWords(placed.flight.warnings), Each(Not(HasSubstr("NOT GEOREFERENCED"))));
    EXPECT_THAT(InWords(placed.flight.warnings), Contains("No records: 20 photos placed."));
    EXPECT_THAT(InWords(placed.flight.warnings), Contains("3 photos are blurred."));
  }
}

TEST(PlaceKnown, PointsWithoutHeightsWillDo) {
  const Nowhere flight;
  PlaceRequest request = flight.BySurvey(4);
  for (flight::GcpPoint& point : request.control.front().points) point.height_m.reset();
  const auto placed = ValueOf(PlaceKnown(flight.known, request));
  EXPECT_LT(flight.WorstTurnRad(placed), 1e-3);
  EXPECT_TRUE(std::isnan(placed.align_report->control[0].miss_up_m));
  const double height_m =
      placed.flight.photos[0].cam_from_enu.TargetOriginInSource().z() - placed.ground.MeanHeight();
  EXPECT_NEAR(height_m, flight.truth.photos[0].pose.cam_from_enu.TargetOriginInSource().z() - kGroundZ, 0.1);
}

// Taken for level, the ground was a slope.
TEST(PlaceKnown, PointsWithHeightsTakeATiltBack) {
  Nowhere flight;
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()));
  for (alignment::AlignedPhoto& photo : flight.known.flight.photos) {
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        photo.cam_from_enu.rotation * tilt.conjugate(), tilt * photo.cam_from_enu.TargetOriginInSource());
  }
  std::vector<float> heights_m;
  for (int row = 0; row < 41; ++row) {
    for (int column = 0; column < 41; ++column)
      heights_m.push_back(static_cast<float>(std::tan(0.03) * (-60.0 + 3.0 * row)));
  }
  flight.known.ground = ground::GroundSurface::Grid({-60.0, -60.0}, 3.0, 41, 41, std::move(heights_m), 0.0);
  const auto placed = ValueOf(PlaceKnown(flight.known, flight.BySurvey(5)));
  EXPECT_LT(flight.WorstOnEarthM(placed), 0.2);
  EXPECT_LT(flight.WorstTurnRad(placed), 2e-3);
  const double level_m = placed.ground.HeightAt({0.0, 0.0});
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(30.0, 20.0), Eigen::Vector2d(-25.0, 30.0), Eigen::Vector2d(0.0, -40.0)})
    EXPECT_NEAR(placed.ground.HeightAt(at), level_m, 0.15) << "the ground is level again";
}

TEST(PlaceKnown, LeavesOutAPointThatTheOthersContradict) {
  const Nowhere flight;
  const auto placed = ValueOf(PlaceKnown(flight.known, flight.BySurvey(5, {25.0, -18.0, 0.0})));
  EXPECT_LT(flight.WorstOnEarthM(placed), 0.1);
  EXPECT_THAT(InWords(placed.flight.warnings), Contains(HasSubstr("point0 is not used: it lies 30.")));
}

TEST(PlaceKnown, RefusesPointsThatContradictEachOther) {
  const Nowhere flight;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, flight.BySurvey(3, {25.0, -18.0, 0.0}))),
              HasSubstr("contradict each other"));
  // Mirrored, as latitude in place of longitude makes them.
  PlaceRequest mirrored = flight.BySurvey(5);
  const geo::LatLon pivot = mirrored.control.front().points.back().position;
  for (flight::GcpPoint& point : mirrored.control.front().points)
    point.position.lon_deg = 2.0 * pivot.lon_deg - point.position.lon_deg;
  bool contradict = false;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, mirrored, &contradict)), HasSubstr("contradict each other"));
  EXPECT_TRUE(contradict);
}

TEST(PlaceKnown, RefusesTooFewPointsAndThoseTooNearTogether) {
  const Nowhere flight;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, flight.BySurvey(2))),
              HasSubstr("Of 2 surveyed points 2 can be used"));
  PlaceRequest unmarked = flight.BySurvey(4);
  for (flight::GcpSighting& sighting : unmarked.control.front().sightings) sighting.image_name = "other.jpg";
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, unmarked)),
              HasSubstr("point0 is marked in fewer than two photos"));
  PlaceRequest near = flight.BySurvey(3);
  flight::GcpList& list = near.control.front();
  list.sightings.clear();  // all three are marked at the place of the first
  const std::vector<flight::GcpList> once = flight.Survey(1);
  for (const flight::GcpSighting& sighting : once.front().sightings) {
    for (std::size_t k = 0; k < 3; ++k) {
      list.sightings.push_back(sighting);
      list.sightings.back().point = k;
    }
  }
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, near)), HasSubstr("too near together"));
}

TEST(PlaceKnown, APlaceAScaleAndNorthWillDo) {
  const Nowhere flight;
  const auto& third = flight.truth.photos[3];
  const geo::Wgs84 at = flight.truth.frame.Wgs84FromEnu(third.pose.cam_from_enu.TargetOriginInSource());
  PlaceRequest request;
  request.origin = geo::LatLon{at.lat_deg, at.lon_deg};
  request.origin_photo = third.photo.name;
  request.factor = 1.0 / 0.37;
  request.north_deg = -geo::RadToDeg(2.1);  // turned left on the map, north points left of its top
  const auto placed = ValueOf(PlaceKnown(flight.known, request));
  EXPECT_LT(flight.WorstTurnRad(placed), 1e-3);
  EXPECT_LT(flight.WorstHorizontallyM(placed), 0.05);
  // The same by what a photo's pixel shows.
  request.factor.reset();
  request.photo_pixel_m = flight.truth.photos[0].pose.cam_from_enu.TargetOriginInSource().z() /
                          flight.truth.options.intrinsics.MeanFocalPx();
  const auto by_pixel = ValueOf(PlaceKnown(flight.known, request));
  EXPECT_NEAR(by_pixel.flight.photos[0].height_above_ground_m, placed.flight.photos[0].height_above_ground_m,
              0.5);
}

TEST(PlaceKnown, TheOriginIsTheMiddleOfThePhotosOrTheTakeOff) {
  Nowhere flight;
  PlaceRequest request;
  request.origin = geo::LatLon{46.8, 7.1};
  const auto middle = ValueOf(PlaceKnown(flight.known, request));
  geo::Bounds2 bounds;
  for (const auto& photo : middle.flight.photos)
    bounds.Include(photo.cam_from_enu.TargetOriginInSource().head<2>());
  EXPECT_LT((bounds.min + bounds.max).norm(), 1e-6);
  flight.known.is_by_images = false;  // reckoned from the take-off
  const auto takeoff = ValueOf(PlaceKnown(flight.known, request));
  EXPECT_LT((takeoff.flight.photos[0].cam_from_enu.TargetOriginInSource() -
             flight.known.flight.photos[0].cam_from_enu.TargetOriginInSource())
                .norm(),
            1e-9);
  EXPECT_EQ(takeoff.flight.frame.origin().lat_deg, 46.8);
}

TEST(PlaceKnown, RefusesWhatMakesNoSense) {
  Nowhere flight;
  PlaceRequest request;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("one of them only"));
  request.origin = geo::LatLon{46.8, 7.1};
  request.factor = 1e6;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("m of ground"));
  request.factor = -1.0;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("above 0"));
  request.factor.reset();
  request.origin_photo = "no.jpg";
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("no photo called no.jpg"));
  request.origin_photo.clear();
  flight.known.is_placed = true;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("--again"));
  request.is_again = true;
  EXPECT_TRUE(PlaceKnown(flight.known, request).ok());
  request.control = flight.Survey(3);
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("one of them only"));
}

// Where the flight shows the ground below one of its photos, and where that truly is.
ShownPair PairBelow(const Nowhere& flight, std::size_t photo) {
  const auto below = [&](const geo::LocalFrame& frame, const geo::Rigid3& cam_from_enu) {
    Eigen::Vector3d at = cam_from_enu.TargetOriginInSource();
    at.z() = kGroundZ;
    const geo::Wgs84 place = frame.Wgs84FromEnu(at);
    return geo::LatLon{place.lat_deg, place.lon_deg};
  };
  return {below(flight.known.flight.frame, flight.known.flight.photos[photo].cam_from_enu),
          below(flight.truth.frame, flight.truth.photos[photo].pose.cam_from_enu)};
}

PlaceRequest ByPairs(const Nowhere& flight, const std::vector<std::size_t>& photos) {
  PlaceRequest request;
  for (const std::size_t photo : photos) request.pairs.push_back(PairBelow(flight, photo));
  return request;
}

TEST(PlaceKnown, TwoPlacesOnTheMapGivePlaceScaleAndNorth) {
  const Nowhere flight;
  for (const auto& photos : {std::vector<std::size_t>{0, 19}, std::vector<std::size_t>{0, 7, 12, 19}}) {
    const auto placed = ValueOf(PlaceKnown(flight.known, ByPairs(flight, photos)));
    EXPECT_LT(flight.WorstHorizontallyM(placed), 0.1);
    EXPECT_LT(flight.WorstTurnRad(placed), 1e-3);
    EXPECT_TRUE(placed.is_placed);
    EXPECT_FALSE(placed.appearance);
    EXPECT_THAT(InWords(placed.flight.warnings), Each(Not(HasSubstr("NOT GEOREFERENCED"))));
    EXPECT_THAT(InWords(placed.flight.warnings), Contains(HasSubstr("placed by hand")));
  }
}

TEST(PlaceKnown, OnePlaceShiftsAMapThatHasItsPlace) {
  Nowhere flight;
  flight.known.is_placed = true;
  const auto placed = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {4})));
  const auto distance = [](const FlightFacts& facts) {
    return (facts.flight.photos[19].cam_from_enu.TargetOriginInSource() -
            facts.flight.photos[0].cam_from_enu.TargetOriginInSource())
        .norm();
  };
  EXPECT_NEAR(distance(placed), distance(flight.known), 0.01);
  const Eigen::Vector3d here = placed.flight.photos[4].cam_from_enu.TargetOriginInSource();
  const Eigen::Vector3d there = placed.flight.frame.EnuAtHeight(PairBelow(flight, 4).is, kGroundZ);
  EXPECT_LT((here - there).head<2>().norm(), 0.05);
}

MapQuality JudgedPlace(const FlightFacts& placed) {
  return JudgeMap({.flight = placed.flight,
                   .poses = placed.poses_report,
                   .alignment = &*placed.align_report,
                   .is_placed = placed.is_placed,
                   .is_by_images = placed.is_by_images,
                   .is_by_hand = placed.is_by_hand});
}

TEST(PlaceKnown, ByHandStatesNoAccuracyOfTheSurveyThatPlacedItBefore) {
  const Nowhere flight;
  const auto surveyed = ValueOf(PlaceKnown(flight.known, flight.BySurvey(4)));
  EXPECT_EQ(JudgedPlace(surveyed).absolute.by, AbsoluteSupport::kControlPoints);
  PlaceRequest request;
  request.origin = geo::LatLon{46.8, 7.1};
  request.is_again = true;
  const auto placed = ValueOf(PlaceKnown(surveyed, request));
  EXPECT_TRUE(placed.align_report->control.empty());
  EXPECT_EQ(JudgedPlace(placed).absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kHand, 0}));
  EXPECT_EQ(JudgedPlace(placed).status, MapStatus::kLimited);
  EXPECT_TRUE(placed.flight.warnings.front() ==
              flight::Remark(flight::RemarkCode::kControlOverruled, {{"points", 4}}));
  EXPECT_THAT(InWords(placed.flight.warnings), Each(Not(HasSubstr("was placed by 4 surveyed points"))));
  const auto again = ValueOf(PlaceKnown(placed, request));
  EXPECT_TRUE(again.flight.warnings.front() == placed.flight.warnings.front()) << "it is so still";
  const auto by_survey = ValueOf(PlaceByLists(again, flight.Survey(4)));
  EXPECT_EQ(JudgedPlace(by_survey).absolute.by, AbsoluteSupport::kControlPoints);
  EXPECT_THAT(InWords(by_survey.flight.warnings), Each(Not(HasSubstr("placed by hand now"))));
}

TEST(PlaceKnown, SaysWhatPlacedItLastAndNotWhatDidBefore) {
  const Nowhere flight;
  const auto by_pairs = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {0, 7, 12, 19})));
  EXPECT_THAT(InWords(by_pairs.flight.warnings), Contains(HasSubstr("by 4 places on it")));
  FlightFacts anew = flight.known;
  ASSERT_TRUE(KeepPlaceByHand(by_pairs, anew));
  EXPECT_THAT(InWords(anew.flight.warnings), Contains(HasSubstr("by 4 places on it")));

  PlaceRequest request;
  request.origin = geo::LatLon{46.9, 7.1};
  request.is_again = true;
  const auto by_origin = ValueOf(PlaceKnown(by_pairs, request));
  EXPECT_THAT(InWords(by_origin.flight.warnings), Each(Not(HasSubstr("by 4 places on it"))));
  EXPECT_THAT(InWords(by_origin.flight.warnings), Contains(HasSubstr("its origin lies at 46.9000000")));
  request.origin->lat_deg = 46.8;
  const auto elsewhere = ValueOf(PlaceKnown(by_origin, request));
  EXPECT_THAT(InWords(elsewhere.flight.warnings), Each(Not(HasSubstr("its origin lies at 46.9000000"))));
  EXPECT_THAT(InWords(elsewhere.flight.warnings), Contains("3 photos are blurred."));

  PlaceRequest survey = flight.BySurvey(4);
  survey.is_again = true;
  const auto surveyed = ValueOf(PlaceKnown(elsewhere, survey));
  EXPECT_THAT(InWords(surveyed.flight.warnings), Each(Not(HasSubstr("placed by hand"))));
  EXPECT_THAT(InWords(surveyed.flight.warnings), Contains(HasSubstr("was placed by 4 surveyed points")));
  survey.control = flight.Survey(5);
  const auto again = ValueOf(PlaceKnown(surveyed, survey));
  EXPECT_THAT(InWords(again.flight.warnings), Each(Not(HasSubstr("was placed by 4 surveyed points"))));
}

// Nothing recorded said how large the flight is, nor where north is.
struct GuessedNowhere : Nowhere {
  GuessedNowhere() {
    alignment::ByImagesReport& by_images = known.align_report->by_images;
    by_images.is_taken = true;
    by_images.is_scale_guessed = true;
    by_images.is_north_guessed = true;
  }
};

TEST(PlaceKnown, OnePlaceLeavesAGuessedScaleAndNorthWhatTheyAre) {
  const GuessedNowhere flight;
  const std::vector<MapLimit> both = {
      {LimitKind::kScaleGuessed}, {LimitKind::kNorthGuessed}, {LimitKind::kPlacedByHand}};
  const auto by_one = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {4})));
  EXPECT_EQ(JudgedPlace(by_one).limits, both);
  EXPECT_EQ(JudgedPlace(by_one).status, MapStatus::kDoubtful);
  PlaceRequest request;
  request.origin = geo::LatLon{46.8, 7.1};
  EXPECT_EQ(JudgedPlace(ValueOf(PlaceKnown(flight.known, request))).limits, both);
  request.factor = 2.0;
  EXPECT_EQ(JudgedPlace(ValueOf(PlaceKnown(flight.known, request))).limits,
            (std::vector<MapLimit>{{LimitKind::kNorthGuessed}, {LimitKind::kPlacedByHand}}));
  request.north_deg = 0.0;
  const std::vector<MapLimit> neither = {{LimitKind::kPlacedByHand}};
  EXPECT_EQ(JudgedPlace(ValueOf(PlaceKnown(flight.known, request))).limits, neither);
  const auto by_two = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {0, 19})));
  EXPECT_EQ(JudgedPlace(by_two).limits, neither);
  // Aligned anew with other photos it is as large as it was said to be.
  FlightFacts anew = flight.known;
  ASSERT_TRUE(KeepPlaceByHand(by_two, anew));
  EXPECT_EQ(JudgedPlace(anew).limits, neither);
  anew = flight.known;
  ASSERT_TRUE(KeepPlaceByHand(by_one, anew));
  EXPECT_EQ(JudgedPlace(anew).limits, both);
}

// No photo is tied to another, and none says how high it was.
TEST(PlaceKnown, OnePlaceLeavesAGuessedHeightAGuessToo) {
  Nowhere flight;
  flight.known.poses_report.is_height_guessed = true;
  for (alignment::AlignedPhoto& photo : flight.known.flight.photos) {
    photo.placement = alignment::Placement::kPoseOnly;
    photo.photo.position.reset();
  }
  const auto by_one = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {4})));
  EXPECT_TRUE(JudgedPlace(by_one).IsLimitedBy(LimitKind::kScaleGuessed));
  EXPECT_EQ(JudgedPlace(by_one).status, MapStatus::kDoubtful);
  const auto by_two = ValueOf(PlaceKnown(flight.known, ByPairs(flight, {0, 19})));
  EXPECT_FALSE(JudgedPlace(by_two).IsLimitedBy(LimitKind::kScaleGuessed));
  FlightFacts anew = flight.known;
  ASSERT_TRUE(KeepPlaceByHand(by_two, anew));
  EXPECT_FALSE(JudgedPlace(anew).IsLimitedBy(LimitKind::kScaleGuessed));
}

TEST(RecallPlacedByHand, TakesTheMapWhileMostOfItsPhotosAreTheSameFiles) {
  Displaced flight({0.0, 1.0, {}});
  FlightFacts& map = flight.known;
  map.is_by_hand = true;
  map.options = DigestOfPlacing({});
  map.appearance.reset();
  map.thumbnails.resize(map.flight.photos.size());
  for (const alignment::AlignedPhoto& photo : map.flight.photos)
    map.inputs.push_back({{photo.photo.name, photo.photo.path}, Digest{1}});
  map.inputs.push_back({{"log.csv", "/then/log.csv"}, Digest{1}});
  test::FactsAlone memory;
  EXPECT_FALSE(RecallPlacedByHand(memory, {}, map.inputs));
  ASSERT_TRUE(memory.Remember(WriteFacts(map)).ok());
  std::vector<NamedDigest> inputs = map.inputs;
  inputs.resize(11);  // of twenty, and no log
  EXPECT_TRUE(RecallPlacedByHand(memory, {}, inputs));
  MosaicOptions others;
  others.max_look_deg = 40.0;
  EXPECT_FALSE(RecallPlacedByHand(memory, others, inputs));
  inputs.back().digest = Digest{2};
  EXPECT_FALSE(RecallPlacedByHand(memory, {}, inputs)) << "ten are";
  map.is_by_hand = false;
  ASSERT_TRUE(memory.Remember(WriteFacts(map)).ok());
  EXPECT_FALSE(RecallPlacedByHand(memory, {}, map.inputs));
}

TEST(PlaceKnown, RefusesPlacesThatTellNothing) {
  const Nowhere flight;
  PlaceRequest request = ByPairs(flight, {0, 0});
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("too near together"));
  request = ByPairs(flight, {0, 19});
  request.pairs[1].is = request.pairs[0].is;
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("too near together"));
  request = ByPairs(flight, {0, 7, 19});
  std::swap(request.pairs[0].is, request.pairs[1].is);
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("contradict each other"));
  request = ByPairs(flight, {0, 19});
  request.origin = geo::LatLon{1.0, 2.0};
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("one of them only"));
  request = ByPairs(flight, {0, 19});
  request.pairs[1].is.lat_deg += 5.0;  // a map of half a thousand kilometres
  EXPECT_THAT(RefusalOf(PlaceKnown(flight.known, request)), HasSubstr("photo's pixel would show"));
}

}  // namespace
}  // namespace skyquilt::pipeline
