// Positions that are those of moments before or after the photos.
#include "core/alignment/from_records/position_lag.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace skyquilt::alignment {
namespace {

constexpr double kIntervalS = 2.0, kSpeedMps = 5.0;
constexpr int kPerLine = 8;

geo::Rigid3 At(const Eigen::Vector3d& center) {
  return geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())), center);
}

// Lines to and fro (or all northwards), right by their photos; records late by `lag_s`, with noise.
struct LaggingFlight {
  BundleProblem problem;
  std::vector<PhotoRecord> records;
  std::vector<double> times_s;

  explicit LaggingFlight(double lag_s, double noise_m = 0.3, int lines = 4, bool is_to_and_fro = true) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, noise_m);
    for (int i = 0; i < lines * kPerLine; ++i) {
      const int line = i / kPerLine;
      const double course = is_to_and_fro && line % 2 == 1 ? -1.0 : 1.0;
      const double along_m = kSpeedMps * kIntervalS * (i % kPerLine);
      const Eigen::Vector3d velocity(0.0, course * kSpeedMps, 0.0);
      const Eigen::Vector3d center(25.0 * line, course > 0.0 ? along_m : 70.0 - along_m, 60.0);
      PhotoRecord record;
      record.center_in_enu = center - lag_s * velocity + Eigen::Vector3d(noise(random), noise(random), 0.0);
      record.sigma_m = {1.5, 1.5, 2.0};
      records.push_back(record);
      BundlePhoto photo;
      photo.cam_from_enu = At(center);
      photo.prior_cam_from_enu = At(*record.center_in_enu);
      problem.photos.push_back(photo);
      Track track;
      track.observations = {{i, {0.0, 0.0}, 1.0}, {(i + 1) % (lines * kPerLine), {0.0, 0.0}, 1.0}};
      problem.tracks.push_back(track);
      times_s.push_back(kIntervalS * i + 10.0 * line);
    }
  }
  std::optional<PositionLag> Find() const { return FindPositionLag(problem, records, times_s); }
};

TEST(FindPositionLag, FindsItEitherWay) {
  for (const double lag_s : {0.4, 2.0, -0.8}) {
    const LaggingFlight flown(lag_s);
    const auto lag = flown.Find();
    ASSERT_TRUE(lag) << lag_s;
    EXPECT_NEAR(lag->lag_s, lag_s, 4.0 * lag->sigma_s);
    EXPECT_NEAR(lag->median_off_m, std::abs(lag_s) * kSpeedMps, 0.5);
    ASSERT_EQ(lag->correction_in_enu.size(), flown.records.size());
    for (std::size_t i = 0; i < flown.records.size(); ++i) {
      const Eigen::Vector3d corrected = *flown.records[i].center_in_enu + lag->correction_in_enu[i];
      EXPECT_LT((corrected - flown.problem.photos[i].cam_from_enu.TargetOriginInSource()).norm(), 1.5) << i;
    }
  }
}

TEST(FindPositionLag, LeavesPositionsThatAgree) {
  EXPECT_FALSE(LaggingFlight(0.0).Find());
  EXPECT_FALSE(LaggingFlight(0.0, 3.0).Find());
  EXPECT_FALSE(LaggingFlight(0.02).Find()) << "ten centimetres change nothing";
}

// Errors that last for minutes look like a lag on two or three lines by chance.
TEST(FindPositionLag, IsNotMisledByReceiversThatWander) {
  int found = 0;
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> of_line(0.0, 1.5);
    LaggingFlight flown(0.0, 0.1, 4);
    for (int line = 0; line < 4; ++line) {
      const Eigen::Vector3d off(of_line(random), of_line(random), 0.0);
      for (int k = 0; k < kPerLine; ++k) {
        const auto i = static_cast<std::size_t>(line * kPerLine + k);
        *flown.records[i].center_in_enu += off;
        flown.problem.photos[i].prior_cam_from_enu = At(*flown.records[i].center_in_enu);
      }
    }
    found += flown.Find() ? 1 : 0;
  }
  EXPECT_LE(found, 3);
}

TEST(FindPositionLag, FindsNothingMoreWhereTheClockIsKnownToBeWrong) {
  LaggingFlight flown(2.0);
  flown.problem.clock_error_s = 2.0;
  for (int i = 0; i < 4 * kPerLine; ++i) {
    const double course = (i / kPerLine) % 2 == 1 ? -1.0 : 1.0;
    flown.problem.photos[static_cast<std::size_t>(i)].by_clock_mps = {0.0, course * kSpeedMps, 0.0};
  }
  EXPECT_FALSE(flown.Find());
}

TEST(FindPositionLag, IsNotToldFromAShiftOnOneCourse) {
  EXPECT_FALSE(LaggingFlight(2.0, 0.3, 4, false).Find());
  EXPECT_FALSE(LaggingFlight(2.0, 0.3, 1).Find());
}

TEST(FindPositionLag, IsNotMisledByAQuarterOfWrongPositions) {
  LaggingFlight flown(1.0);
  for (std::size_t i = 0; i < flown.records.size(); i += 4) {
    const Eigen::Vector3d wrong = *flown.records[i].center_in_enu + Eigen::Vector3d(40.0, 30.0, 0.0);
    flown.records[i].center_in_enu = wrong;
    flown.problem.photos[i].prior_cam_from_enu = At(wrong);
  }
  const auto lag = flown.Find();
  ASSERT_TRUE(lag);
  EXPECT_NEAR(lag->lag_s, 1.0, 0.15);
}

TEST(FindPositionLag, TakesFlightsWithoutPhotosPositionsOrMotion) {
  EXPECT_FALSE(FindPositionLag({}, {}, {}));
  LaggingFlight nowhere(1.0);
  for (PhotoRecord& record : nowhere.records) record.center_in_enu.reset();
  EXPECT_FALSE(nowhere.Find());
  LaggingFlight still(1.0);
  for (BundlePhoto& photo : still.problem.photos) photo.cam_from_enu = At({0.0, 0.0, 60.0});
  EXPECT_FALSE(still.Find());
  LaggingFlight at_once(1.0);
  at_once.times_s.assign(at_once.times_s.size(), 7.0);
  EXPECT_FALSE(at_once.Find());
}

}  // namespace
}  // namespace skyquilt::alignment
