#include "core/poses/heights/takeoff.h"

#include <gtest/gtest.h>

namespace skyquilt::poses {
namespace {

// A log of 60 s: ten seconds at 100 m (ellipsoid) on the ground, then 60 m higher; photos from 30 s on.
class FindTakeoffTest : public testing::Test {
 protected:
  FindTakeoffTest() : photos_(3) {
    for (int k = 0; k <= 300; ++k) {
      const double t_s = 0.2 * k;
      flight::GnssSample fix;
      fix.t_s = t_s;
      fix.position = {50.8 + 1e-5 * k, -0.1};
      fix.height_ellipsoid_m = 100.0 + AboveM(t_s);
      log_.gnss.push_back(fix);
    }
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      photos_[i].intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
      photos_at_.push_back({&photos_[i], 30.1 + 5.0 * static_cast<double>(i), 0.0, {}});
    }
  }
  static double AboveM(double t_s) { return t_s < 10.0 ? 0.0 : 60.0; }
  void AddBarometer() {
    for (int k = 0; k <= 600; ++k) log_.baro.push_back({0.1 * k, AboveM(0.1 * k)});
  }
  void AddRange(double ground_above_takeoff_m) {
    for (int k = 0; k <= 100; ++k) log_.range.push_back({30.0 + 0.1 * k, 60.0 - ground_above_takeoff_m});
  }
  Takeoff Find() const { return FindTakeoff(log_, photos_at_); }

  flight::FlightLog log_;
  std::vector<flight::Photo> photos_;
  std::vector<PhotoAtTime> photos_at_;
};

TEST_F(FindTakeoffTest, TrustsTheBarometerFirst) {
  AddBarometer();
  for (flight::Photo& photo : photos_) {
    photo.position.emplace();
    photo.position->height_above_takeoff_m = 10.0;  // contradicts it
  }
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 100.0, 1e-6);
  EXPECT_NE(takeoff.rule.find("barometer"), std::string::npos) << takeoff.rule;
  EXPECT_EQ(takeoff.ground_above_takeoff_m, 0.0);
  EXPECT_TRUE(takeoff.is_above_ellipsoid);
  for (flight::GnssSample& fix : log_.gnss) fix.height_ellipsoid_m.reset();
  EXPECT_FALSE(Find().is_above_ellipsoid) << "the barometer alone counts from take-off";
  ASSERT_TRUE(takeoff.position.has_value());
  EXPECT_DOUBLE_EQ(takeoff.position->lat_deg, 50.8);
  ASSERT_TRUE(takeoff.middle.has_value());
  EXPECT_NEAR(takeoff.middle->lat_deg, 50.8 + 1e-5 * 176, 2e-5);
}

TEST_F(FindTakeoffTest, HangsFixesWithoutHeightsOnThePhotosOwn) {
  AddBarometer();
  for (flight::GnssSample& fix : log_.gnss) fix.height_ellipsoid_m.reset();
  for (flight::Photo& photo : photos_) {
    photo.position.emplace();
    photo.position->height_ellipsoid_m = 512.0;
  }
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 452.0, 1e-6);
  EXPECT_TRUE(takeoff.is_above_ellipsoid);
  EXPECT_TRUE(takeoff.hangs_on_cameras);
}

TEST_F(FindTakeoffTest, ReadsTablesOfARowEveryFiveSeconds) {
  const std::vector<flight::GnssSample> all = std::move(log_.gnss);
  log_.gnss.clear();
  for (std::size_t k = 0; k < all.size(); k += 25) {
    log_.gnss.push_back(all[k]);
    log_.baro.push_back({all[k].t_s, AboveM(all[k].t_s)});
  }
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 100.0, 1e-6);
  EXPECT_TRUE(takeoff.is_above_ellipsoid);
}

TEST_F(FindTakeoffTest, MovesTheGroundToWhereTheRangeFinderSeesIt) {
  AddBarometer();
  AddRange(4.0);
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 100.0, 1e-6);
  EXPECT_NEAR(takeoff.ground_above_takeoff_m, 4.0, 1e-6);
}

TEST_F(FindTakeoffTest, DoesNotBelieveARangeFinderAtItsLimit) {
  AddBarometer();
  for (int k = 0; k <= 100; ++k) {
    const double t_s = 30.0 + 0.1 * k;
    log_.range.push_back({t_s, 30.0});  // whatever the height
    log_.baro[static_cast<std::size_t>(300 + k)].height_above_takeoff_m = 40.0 + 0.4 * k;
  }
  EXPECT_EQ(Find().ground_above_takeoff_m, 0.0);
}

TEST_F(FindTakeoffTest, DoesNotBelieveALimitThatAFlightOfConstantHeightRepeats) {
  AddBarometer();
  for (int k = 0; k < 10; ++k) log_.range.push_back({11.0 + 0.1 * k, 5.0 + k});
  for (int k = 0; k <= 100; ++k) log_.range.push_back({30.0 + 0.1 * k, 40.0});
  const Takeoff takeoff = Find();
  EXPECT_EQ(takeoff.ground_above_takeoff_m, 0.0);
  EXPECT_EQ(takeoff.rule.find("range finder"), std::string::npos) << takeoff.rule;
}

TEST_F(FindTakeoffTest, TakesTheRangeFinderWithoutABarometer) {
  AddRange(0.0);
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 100.0, 1e-6);
  EXPECT_NE(takeoff.rule.find("range finder"), std::string::npos) << takeoff.rule;
}

TEST_F(FindTakeoffTest, TakesThePhotosRelativeHeightsNext) {
  for (flight::Photo& photo : photos_) {
    photo.position.emplace();
    photo.position->height_above_takeoff_m = 55.0;
  }
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 105.0, 1e-6);
  EXPECT_NE(takeoff.rule.find("photos record"), std::string::npos) << takeoff.rule;
}

TEST_F(FindTakeoffTest, TakesTheBeginningOfALogThatRises) {
  const Takeoff takeoff = Find();
  EXPECT_NEAR(takeoff.height_ellipsoid_m, 100.0, 1e-6);
  EXPECT_NE(takeoff.rule.find("where the log begins"), std::string::npos) << takeoff.rule;
}

TEST_F(FindTakeoffTest, GuessesAndWarnsForALogThatBeginsInTheAir) {
  for (flight::GnssSample& fix : log_.gnss) fix.height_ellipsoid_m = 160.0;
  const Takeoff takeoff = Find();
  EXPECT_NE(takeoff.rule.find("guessed"), std::string::npos) << takeoff.rule;
  EXPECT_TRUE(takeoff.assumption.has_value());
  EXPECT_LT(takeoff.height_ellipsoid_m, 155.0);
}

TEST_F(FindTakeoffTest, SaysNothingOfAPlaceWithoutAnyPosition) {
  log_.gnss.clear();
  AddBarometer();
  const Takeoff takeoff = Find();
  EXPECT_FALSE(takeoff.middle.has_value());
  EXPECT_FALSE(takeoff.position.has_value());
}

}  // namespace
}  // namespace skyquilt::poses
