#include "core/poses/plausible_poses.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::poses {
namespace {

using ::testing::HasSubstr;

CameraStand LookingDown(double east_m, double north_m, double height_m) {
  return {camera::Intrinsics::Centered(4000, 3000, 3000.0),
          geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0),
                                                   {east_m, north_m, height_m}),
          height_m};
}

// Five that are well, then those given.
std::vector<std::optional<flight::Remark>> WhyBesideFive(const std::vector<CameraStand>& stands,
                                                         double lat_deg = 46.8) {
  std::vector<CameraStand> all;
  for (int i = 0; i < 5; ++i) all.push_back(LookingDown(10.0 * i, 0.0, 50.0));
  all.insert(all.end(), stands.begin(), stands.end());
  auto why = WhyImplausible(all, geo::LocalFrame({lat_deg, 7.1, 500.0}));
  for (int i = 0; i < 5 && std::abs(lat_deg) < 85.0; ++i) EXPECT_FALSE(why[static_cast<std::size_t>(i)]);
  why.erase(why.begin(), why.begin() + 5);
  return why;
}

std::string Why(const CameraStand& stand) { return InWords(WhyBesideFive({stand})[0].value_or("")); }

TEST(WhyImplausible, NamesWhatIsWrong) {
  EXPECT_THAT(Why(LookingDown(0.0, 0.0, std::numeric_limits<double>::quiet_NaN())),
              HasSubstr("not a number"));
  EXPECT_THAT(Why(LookingDown(std::numeric_limits<double>::infinity(), 0.0, 50.0)),
              HasSubstr("not a number"));
  EXPECT_THAT(Why(LookingDown(0.0, 0.0, -47.0)), HasSubstr("47.0 m below the ground"));
  EXPECT_THAT(Why(LookingDown(0.0, 0.0, 0.1)), HasSubstr("0.1 m above the ground"));
  EXPECT_THAT(Why(LookingDown(1e6, 0.0, 50.0)), HasSubstr("km away"));
  EXPECT_THAT(Why(LookingDown(0.0, 0.0, 5000.0)), HasSubstr("10000 times as much ground"));
  for (const auto& [lat_deg, where] : {std::pair{86.5, "at 86.50 degrees"}, {-89.0, "at -89.00 degrees"}}) {
    const std::string why = InWords(*WhyBesideFive({LookingDown(0.0, 0.0, 50.0)}, lat_deg)[0]);
    EXPECT_THAT(why, testing::AllOf(HasSubstr(where), HasSubstr("beyond 85 degrees")));
  }
}

// A kilometre too high: 400 times the ground of the others, and at their resolution more than can be drawn.
TEST(WhyImplausible, LeavesOutWhatWouldBeDrawnInTooManyPixels) {
  CameraStand fine = LookingDown(0.0, 0.0, 900.0);
  EXPECT_FALSE(WhyBesideFive({fine})[0]) << "324 times the ground in 12 megapixels each";
  std::vector<CameraStand> large(6, LookingDown(0.0, 0.0, 50.0));
  for (CameraStand& stand : large) stand.intrinsics = camera::Intrinsics::Centered(8000, 6000, 6000.0);
  large.back() = LookingDown(0.0, 0.0, 900.0);
  const auto why = WhyImplausible(large, geo::LocalFrame({46.8, 7.1, 500.0}));
  EXPECT_FALSE(why[0]);
  ASSERT_TRUE(why[5]);
  EXPECT_EQ(why[5]->code, flight::RemarkCode::kLeftTooMuchGround);
}

TEST(WhyImplausible, AFlightThatIsTogetherElsewhereThanOnEarthIsNowhere) {
  const std::vector<CameraStand> far(3, LookingDown(0.0, 1e298, 50.0));
  for (const auto& why : WhyImplausible(far, geo::LocalFrame({46.8, 7.1, 500.0})))
    EXPECT_THAT(InWords(why.value_or("")), HasSubstr("none that can be"));
  for (const auto& why : WhyBesideFive(std::vector<CameraStand>(9, LookingDown(0.0, 0.0, 1e298))))
    EXPECT_THAT(InWords(why.value_or("")), HasSubstr("none that can be"));
}

TEST(WhyImplausible, AFocalLengthThatNoLensHas) {
  for (const double focal_px : {0.0, 1e-300, 1.0, 1e8, 1e300}) {
    CameraStand stand = LookingDown(0.0, 0.0, 50.0);
    stand.intrinsics.focal_x_px = stand.intrinsics.focal_y_px = focal_px;
    EXPECT_THAT(Why(stand), HasSubstr("none that can be")) << focal_px;
  }
  CameraStand fisheye = LookingDown(0.0, 0.0, 50.0);
  fisheye.intrinsics.focal_x_px = fisheye.intrinsics.focal_y_px = 900.0;
  EXPECT_EQ(Why(fisheye), "");
}

TEST(WhyImplausible, LeavesHonestFlightsAlone) {
  EXPECT_EQ(Why(LookingDown(1000.0, 0.0, 20.0)), "");
  EXPECT_EQ(Why(LookingDown(0.0, 0.0, 5.0)), "");
  EXPECT_EQ(Why(LookingDown(0.0, 0.0, 500.0)), "");
  CameraStand up = LookingDown(0.0, 0.0, 50.0);
  up.cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(), {0.0, 0.0, 50.0});
  EXPECT_EQ(Why(up), "");
  CameraStand aslant = LookingDown(0.0, 0.0, 50.0);
  aslant.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitX())) *
          Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0),
      {0.0, 0.0, 50.0});
  EXPECT_EQ(Why(aslant), "");
}

TEST(WhyImplausible, TakesFlightsOfAnySize) {
  const geo::LocalFrame frame({46.8, 7.1, 500.0});
  EXPECT_TRUE(WhyImplausible({}, frame).empty());
  EXPECT_FALSE(WhyImplausible({LookingDown(0.0, 0.0, 50.0)}, frame)[0]);
  EXPECT_TRUE(WhyImplausible({LookingDown(0.0, 0.0, std::numeric_limits<double>::quiet_NaN())}, frame)[0]);
}

}  // namespace
}  // namespace skyquilt::poses
