#include "core/alignment/estimators/two_view.h"

#include <gtest/gtest.h>

#include "core/alignment/matching/match_descriptors.h"
#include "tests/core/alignment/registration/synthetic_scene.h"
#include "tests/support/value_of.h"

namespace skyquilt::alignment {
namespace {

std::optional<PhotoPair> View(const SyntheticScene& scene, int i, int j) {
  const Registration input = InputOf(scene);
  return VerifyTwoViews(input, RaysOf(input, 2000, 1),
                        {i, j, {}, MatchDescriptors(scene.features[i], scene.features[j])});
}

double TurnError(const SyntheticScene& scene, int i, int j, const PhotoPair& view) {
  const Eigen::Quaterniond truth =
      scene.cam_from_enu[j].rotation * scene.cam_from_enu[i].rotation.conjugate();
  double least = 10.0;
  for (const geo::Rigid3& pose : view.poses) least = std::min(least, pose.rotation.angularDistance(truth));
  return least;
}

TEST(TwoView, TheTurnIsFoundOverFlatGroundAndOverRelief) {
  SyntheticOptions options{.columns = 2, .rows = 1, .relief_m = 0.0, .any_yaw = true};
  const SyntheticScene flat = MakeScene(options);
  EXPECT_LT(TurnError(flat, 0, 1, test::ValueOf(View(flat, 0, 1))), 0.02);
  options.relief_m = 15.0;
  const SyntheticScene hills = MakeScene(options);
  EXPECT_LT(TurnError(hills, 0, 1, test::ValueOf(View(hills, 0, 1))), 0.01);
}

// A camera far to the side sees level ground as one that turned sees ground along its edge.
TEST(TwoView, OfTwoGroundsTheOneUnderTheCamerasComesFirst) {
  SyntheticOptions options{.columns = 2, .rows = 1, .relief_m = 0.0, .tilt_rad = 0.02};
  for (const double step_m : {6.0, 15.0, 25.0}) {
    options.step_m = step_m;
    const SyntheticScene scene = MakeScene(options);
    const auto view = View(scene, 0, 1);
    ASSERT_TRUE(view) << step_m;
    const Eigen::Quaterniond truth =
        scene.cam_from_enu[1].rotation * scene.cam_from_enu[0].rotation.conjugate();
    EXPECT_LT(view->poses.front().rotation.angularDistance(truth), 0.02) << step_m;
    EXPECT_NEAR(view->angle_rad, step_m / options.height_m, 0.3 * step_m / options.height_m);
  }
}

TEST(TwoView, ACameraThatOnlyTurnedHasNoParallax) {
  SyntheticScene scene = MakeScene({.columns = 2, .rows = 1, .step_m = 0.0, .any_yaw = true});
  // The same place: the second is the first, turned in the picture's plane and seen anew.
  scene.features[1] = scene.features[0];
  for (Keypoint& keypoint : scene.features[1].keypoints) {
    const float x = keypoint.x_px;
    keypoint.x_px = 3999.0F - x;
    keypoint.y_px = 2999.0F - keypoint.y_px;
    keypoint.angle_rad += 3.14159265F;
  }
  const auto view = test::ValueOf(View(scene, 0, 1));
  EXPECT_TRUE(view.poses.front().translation.isZero());
  EXPECT_LT(view.angle_rad, 0.005);
}

TEST(TwoView, PhotosOfDifferentPlacesAreNotTied) {
  SyntheticOptions options{.columns = 2, .rows = 1};
  SyntheticScene scene = MakeScene(options);
  options.seed = 99;
  scene.features[1] = MakeScene(options).features[1];
  EXPECT_FALSE(View(scene, 0, 1));
}

}  // namespace
}  // namespace skyquilt::alignment
