#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/camera/footprint.h"
#include "core/poses/conventions/attitude_convention.h"
#include "tests/support/ground_homography.h"
#include "tests/support/value_of.h"

namespace skyquilt::camera {
namespace {

constexpr double kPi = 3.14159265358979323846;

geo::Rigid3 Pose(double yaw_deg, double pitch_deg, double roll_deg, const Eigen::Vector3d& center) {
  flight::RecordedAttitude attitude;
  attitude.yaw_rad = yaw_deg * kPi / 180, attitude.pitch_rad = pitch_deg * kPi / 180,
  attitude.roll_rad = roll_deg * kPi / 180;
  return geo::Rigid3::FromRotationAndTargetOrigin(poses::CamFromEnu(attitude), center);
}

TEST(GroundHomography, IsTheRayThroughThePlaneForEveryPose) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Intrinsics lens = Intrinsics::Centered(1600, 1200, 1150.0);
  for (int i = 0; i < 300; ++i) {
    const double plane_z_m = 10.0 * unit(random);
    const geo::Rigid3 pose =
        Pose(180.0 * unit(random), -90.0 + 20.0 * unit(random), 15.0 * unit(random),
             {500.0 * unit(random), 500.0 * unit(random), plane_z_m + 70.0 + 50.0 * unit(random)});
    const Eigen::Matrix3d g = test::GroundHomography(lens, pose, plane_z_m);
    const Eigen::Vector2d pixel{800.0 + 799.0 * unit(random), 600.0 + 599.0 * unit(random)};
    const auto ground = test::ValueOf(GroundFromPixel(lens, pose, pixel, plane_z_m));
    const Eigen::Vector3d image = g * Eigen::Vector3d(ground.x(), ground.y(), 1.0);
    EXPECT_LT((Eigen::Vector2d(image.head<2>() / image.z()) - pixel).norm(), 1e-7);
    EXPECT_LT((test::ValueOf(lens.Project(pose * ground)) - pixel).norm(), 1e-7);
  }
}

// H = K_j (R_jk + t_jk n^T / h) K_k^-1 for the plane n.X_k = h below camera k: the textbook's other form.
TEST(GroundHomography, ComposesToTheTextbooksImageToImageForm) {
  const Intrinsics lens_k = Intrinsics::Centered(4000, 2250, 2222.0);
  const Intrinsics lens_j = Intrinsics::Centered(5472, 3648, 3650.0);
  const geo::Rigid3 k_from_enu = Pose(45.0, -88.0, 1.0, {3.0, 4.0, 40.0});
  const geo::Rigid3 j_from_enu = Pose(-130.0, -93.0, -2.0, {12.0, -6.0, 47.0});
  const geo::Rigid3 j_from_k = j_from_enu * k_from_enu.Inverse();
  const Eigen::Vector3d down_in_k = k_from_enu.rotation * -Eigen::Vector3d::UnitZ();
  const double height_m = 40.0;
  Eigen::Matrix3d textbook =
      lens_j.K() *
      (j_from_k.rotation.toRotationMatrix() + j_from_k.translation * down_in_k.transpose() / height_m) *
      lens_k.K().inverse();
  Eigen::Matrix3d ours = test::GroundHomography(lens_j, j_from_enu, 0.0) *
                         test::GroundHomography(lens_k, k_from_enu, 0.0).inverse();
  textbook /= textbook(2, 2);
  ours /= ours(2, 2);
  EXPECT_LT((textbook - ours).cwiseAbs().maxCoeff() / ours.cwiseAbs().maxCoeff(), 1e-10);
}

TEST(GroundFromPixel, SeesNoGroundAtOrAboveTheHorizon) {
  const Intrinsics lens = Intrinsics::Centered(1000, 800, 900.0);
  const geo::Rigid3 pose = Pose(0.0, 5.0, 0.0, {0, 0, 50.0});
  EXPECT_FALSE(GroundFromPixel(lens, pose, {500.0, 400.0}, 0.0).has_value());
  EXPECT_TRUE(GroundFootprint(lens, Pose(0.0, 20.0, 0.0, {0, 0, 50.0}), 0.0).empty());
  EXPECT_TRUE(GroundFootprint(lens, Pose(0, -90, 0, {0, 0, -3.0}), 0.0).empty());
}

// The horizon in the upper part, the ground in the lower, which counts as far as the look angle lets it.
TEST(Footprint, OfAPhotoWithTheHorizonInItEndsAtTheLookAngle) {
  const Intrinsics lens = Intrinsics::Centered(1000, 800, 700.0);
  const geo::Rigid3 pose = Pose(0.0, -5.0, 0.0, {10, 20, 50.0});
  const double max_rad = geo::DegToRad(65.0);
  const auto polygon = GroundFootprint(lens, pose, 0.0, 8, max_rad);
  ASSERT_FALSE(polygon.empty());
  for (const Eigen::Vector2d& point : polygon) {
    EXPECT_LE((point - Eigen::Vector2d(10, 20)).norm(), 50.0 * std::tan(max_rad) + 1e-6);
    EXPECT_GT(point.y(), 20.0) << "it looks north";
  }
  EXPECT_TRUE(GroundFootprint(lens, pose, 0.0, 8, geo::DegToRad(50.0)).empty());
}

TEST(Footprint, OfALevelPhotoIsItsRectangle) {
  const Intrinsics lens = Intrinsics::Centered(1000, 800, 1000.0);
  const auto polygon = GroundFootprint(lens, Pose(30.0, -90.0, 0.0, {10, 20, 50.0}), 0.0);
  EXPECT_NEAR(AreaM2(polygon), 50.0 * 40.0, 1e-6);
  EXPECT_TRUE(PolygonContains(polygon, {10, 20}));
  EXPECT_FALSE(PolygonContains(polygon, {10, 80}));
}

}  // namespace
}  // namespace skyquilt::camera
