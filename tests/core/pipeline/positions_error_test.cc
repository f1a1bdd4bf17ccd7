// What recorded positions place, and that over many simulated flights the stated one sigma is one.
#include "core/pipeline/report/positions_error.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <random>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/poses/time/time_sync.h"
#include "tests/core/pipeline/judged_flight.h"

namespace skyquilt::pipeline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(PositionsError, StatesWhatThePositionsShareWhereTheyAgree) {
  JudgedFlight flight(18);
  const MapQuality plain = flight.Judge();
  EXPECT_EQ(plain.absolute, (AbsoluteAccuracy{2.3, AbsoluteSupport::kGnss, 18}));  // 1.515 x 1.5 m
  EXPECT_EQ(plain.relative, (RelativeAccuracy{0.01, 0.5, RelativeSupport::kTiePoints, 1000}));
  EXPECT_EQ(plain.status, MapStatus::kReady);
  for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = true;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 18}));
}

// All photos lie off by what their datum's place on Earth is not known to, however well they agree.
TEST(PositionsError, AddsWhatTheSystemOfThePositionsIsKnownTo) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) {
    photo.photo.position->is_rtk_fixed = true;
    photo.photo.position->system_error_m = 5.0;
  }
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{5.0, AbsoluteSupport::kRtk, 18}));
  for (auto& photo : flight.flight.photos) photo.photo.position->system_error_m = 300.0;
  EXPECT_EQ(flight.Judge().limits, (std::vector<MapLimit>{{LimitKind::kFarOff}}));
}

// Within each part they agree: what the map misses them by says nothing of it.
TEST(PositionsError, IsNoLessThanWhatCorrectedPositionsJumpBy) {
  JudgedFlight flight(36);
  for (std::size_t i = 0; i < 36; ++i) {
    alignment::AlignedPhoto& photo =
        flight.flight.photos[35 - i];  // the last in the folder is the first flown
    const Vector2d stands = photo.cam_from_enu.TargetOriginInSource().head<2>();
    const double miss_m = i == 17 || i == 18   ? 0.2
                          : i == 16 || i == 19 ? 0.15
                          : i == 15 || i == 20 ? 0.1
                                               : 0.0;
    flight.Record(35 - i, stands + Vector2d(i < 18 ? -miss_m : miss_m, 0.0));
    photo.photo.position->is_rtk_fixed = true;
    photo.photo.captured_at = flight::UtcTime(std::chrono::seconds(i));
  }
  const MapQuality quality = flight.Judge();
  EXPECT_NEAR(*quality.absolute.sigma_m, 0.3, 0.02);
  EXPECT_EQ(quality.absolute.by, AbsoluteSupport::kRtk);
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}}));
  const std::vector<flight::Remark> remarks = RemarksOnPositions(flight.Map());
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(remarks[0].code, flight::RemarkCode::kPositionsJump);
  EXPECT_THAT(flight::InWords(remarks[0]),
              ::testing::HasSubstr("Between p18 and p17 the recorded positions jump by 0.3"));
  // Points near one place tell of one side.
  JudgedFlight checked = flight, held = flight;
  checked.Surveyed(true, 0.01, 0.0);
  for (int k = 0; k < 2; ++k) held.Surveyed(false, 0.01, 0.0);
  for (const JudgedFlight& surveyed : {checked, held}) {
    EXPECT_EQ(surveyed.Judge().limits, (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}}));
    EXPECT_EQ(RemarksOnPositions(surveyed.Map()), remarks);
  }
  EXPECT_GE(*checked.Judge().absolute.sigma_m, *quality.absolute.sigma_m);
  for (int k = 0; k < 4; ++k) checked.Surveyed(true, 0.01, 0.0);
  EXPECT_EQ(checked.Judge().status, MapStatus::kReady) << "five, over all of it";
  EXPECT_TRUE(RemarksOnPositions(checked.Map()).empty());
}

TEST(PositionsError, SaysWhereCorrectedHeightsJump) {
  JudgedFlight flight(60);
  for (std::size_t i = 0; i < 60; ++i) {
    alignment::AlignedPhoto& photo = flight.flight.photos[i];
    const double to_jump = static_cast<double>(i) - 29.5;
    const Vector3d at = photo.cam_from_enu.TargetOriginInSource() +
                        std::copysign(0.25 * std::exp(-std::abs(to_jump) / 4.0), to_jump) * Vector3d::UnitZ();
    flight::RecordedPosition& record = *photo.photo.position;
    record.height_ellipsoid_m = flight.flight.frame.Wgs84FromEnu(at).height_ellipsoid_m;
    record.is_rtk_fixed = true;
    photo.photo.captured_at = flight::UtcTime(std::chrono::seconds(i));
  }
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 60})) << "which is horizontal";
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}}));
  const std::vector<flight::Remark> remarks = RemarksOnPositions(flight.Map());
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(remarks[0].code, flight::RemarkCode::kHeightsJump);
  EXPECT_THAT(flight::InWords(remarks[0]),
              ::testing::HasSubstr("Between p29 and p30 the recorded heights jump by 0.3"));
  for (auto& photo : flight.flight.photos) photo.photo.position->is_rtk_fixed = false;
  EXPECT_TRUE(RemarksOnPositions(flight.Map()).empty()) << "a barometer drifts";
}

TEST(PositionsError, ByRecordsAloneEachPhotoIsAsFarOffAsItSays) {
  JudgedFlight flight(5);
  for (auto& photo : flight.flight.photos) photo.placement = alignment::Placement::kPoseOnly;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{9.0, AbsoluteSupport::kGnss, 5}));
  EXPECT_FALSE(quality.IsLimitedBy(LimitKind::kFewPositions)) << "all five have one";
  EXPECT_EQ(quality.status, MapStatus::kLimited);
}

TEST(PositionsError, NeverCallsUsableWhatAHandfulOfPhotosPlaces) {
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

TEST(PositionsError, LetsARefutedPositionPlaceNothing) {
  JudgedFlight flight(18);
  flight.Record(3, {5000.0, 0.0});
  EXPECT_GT(*flight.Judge().absolute.sigma_m, 10.0);
  flight.Refute(3);
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{2.3, AbsoluteSupport::kGnss, 17}));
}

TEST(PositionsError, DoubtsAMapOfWhichEveryPositionIsRefuted) {
  JudgedFlight flight(2);
  for (const std::size_t i : {0u, 1u}) flight.Refute(i);
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, AbsoluteAccuracy());
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kFewPositions, 0, 2}}));
}

TEST(PositionsError, CountsAFixThatPhotosRepeatOnce) {
  JudgedFlight flight(12);
  for (std::size_t i = 0; i < 12; ++i) flight.flight.photos[i].photo.position->is_repeated = i % 3 != 0;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{std::nullopt, AbsoluteSupport::kGnss, 4}));
  EXPECT_EQ(quality.status, MapStatus::kDoubtful);
}

// Of a picture that was cut: the lines flown one way refute those flown the other, all by the same way.
TEST(PositionsError, IsNoBetterThanTheManyPositionsThatItRefutes) {
  JudgedFlight flight(12);
  for (std::size_t i = 5; i < 10; ++i) flight.Misplace(i, {0.0, 15.0});
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{12.0, AbsoluteSupport::kGnss, 7}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
  EXPECT_EQ(quality.limits,
            (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}, {LimitKind::kFarOff}}));
}

TEST(PositionsError, SuspectsAFewRefutedPositionsOnlyWhereTheyAgree) {
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
TEST(PositionsError, TakesNoRefutedPositionForFurtherOffThanTheMapIsLong) {
  JudgedFlight flight(12);
  for (std::size_t i = 5; i < 10; ++i) flight.Misplace(i, {0.0, 9000.0});
  EXPECT_TRUE(flight.Judge().IsLimitedBy(LimitKind::kPositionsContradicted));
  EXPECT_LT(*flight.Judge().absolute.sigma_m, 110.0);
}

TEST(PositionsError, IsNoBetterThanTheWarningOfContradictedPositionsSays) {
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
  flight.Surveyed(true, 0.03, 0.04);
  EXPECT_EQ(flight.Judge().limits, (std::vector<MapLimit>{{LimitKind::kPositionsContradicted}}))
      << "of elsewhere one check point says nothing";
  for (int k = 0; k < 2; ++k) flight.Surveyed(true, 0.03, 0.04);
  EXPECT_EQ(flight.Judge().status, MapStatus::kReady) << "three say how far off it is";
}

TEST(PositionsError, TakesALogsPositionsForThePhotosOfTheLog) {
  JudgedFlight flight(18);
  for (auto& photo : flight.flight.photos) photo.photo.position.reset();
  flight.poses.photos_by_log = 18;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{9.0, AbsoluteSupport::kHand, 18}));
  flight.poses.log_position_sigma_m = 0.02;
  flight.poses.log_is_corrected = true;
  EXPECT_EQ(flight.Judge().absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, 18}));
}

TEST(PositionsError, IsNotReadyWhereAListContradictsThePhotosOwnPositions) {
  JudgedFlight flight(18);
  flight.poses.lists_contradict_m = 14.0;
  const MapQuality quality = flight.Judge();
  EXPECT_EQ(quality.absolute, (AbsoluteAccuracy{21.0, AbsoluteSupport::kGnss, 18}));  // 1.515 x 14 m
  EXPECT_EQ(quality.limits, (std::vector<MapLimit>{{LimitKind::kFarOff}}));
  EXPECT_EQ(quality.status, MapStatus::kLimited);
}

TEST(PositionsError, DoubtsAMapWhosePhotosMayLieElsewhereOnTheTrack) {
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

TEST(PositionsError, CoversTwoThirdsOfTheErrorsWhereTheCommonErrorIsAsAssumed) {
  for (const int photos : {9, 24, 60}) {
    for (const auto& [noise_m, is_corrected] : {std::pair{0.02, true}, {1.0, false}, {3.0, false}}) {
      const double share = CoveredShare(noise_m, is_corrected ? 0.02 : 1.5, is_corrected, photos);
      EXPECT_GT(share, 0.62) << noise_m << " m, " << photos << " photos";
      EXPECT_LT(share, 0.75) << noise_m << " m, " << photos << " photos";
    }
  }
}

TEST(PositionsError, CoversMoreWithoutTheAssumedCommonError) {
  EXPECT_GT(CoveredShare(1.0, 0.0, false, 24), 0.95);
}

}  // namespace
}  // namespace skyquilt::pipeline
