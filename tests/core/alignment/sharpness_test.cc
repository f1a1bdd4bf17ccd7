// Simulated photos of which it is known whether they are blurred.
#include "core/alignment/features/sharpness.h"

#include <gtest/gtest.h>

#include <tuple>

#include "core/geo/lat_lon.h"
#include "core/simulate/sensors/trajectory.h"
#include "core/simulate/world/render_photo.h"

namespace skyquilt::alignment {
namespace {

constexpr double kLowHeightM = 40.0;
const Eigen::Vector3d kStill = Eigen::Vector3d::Zero();

struct Picture {
  View view;
  PictureDetail detail;
};

// Over (east, 0), the image's top turned clockwise from north.
Picture Take(simulate::TextureLevel texture, double east_m, double yaw_rad, const Eigen::Vector3d& motion_m) {
  simulate::WorldOptions world;
  world.texture = texture;
  Picture picture;
  picture.view.intrinsics = camera::Intrinsics::Centered(600, 450, 600.0);
  picture.view.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      simulate::CamFromEnuOfGimbal({yaw_rad, -0.5 * geo::kPi, 0.0}), {east_m, 0.0, kLowHeightM});
  picture.view.height_above_ground_m = kLowHeightM;
  simulate::RenderPhotoOptions options;
  options.motion_in_enu_m = motion_m;
  options.noise_counts = 0.25;  // what shrinking leaves of it
  options.noise_seed = static_cast<std::uint32_t>(1000.0 * (east_m + yaw_rad));
  const image::DecodedImage image = simulate::RenderPhoto(simulate::World(world), picture.view.intrinsics,
                                                          picture.view.cam_from_enu, options);
  std::vector<std::uint8_t> grey;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) grey.push_back(image.rgb[i + 1]);
  picture.detail = MeasureDetail(image.width_px, image.height_px, grey.data());
  return picture;
}

double Against(const Picture& own, const Picture& other) {
  const auto share = SharpnessAgainst(own.detail, own.view, other.detail, other.view, Relief(0.0));
  EXPECT_TRUE(share.has_value());
  return share.value_or(-1.0);
}

class OverGround : public testing::TestWithParam<std::tuple<simulate::TextureLevel, double>> {};

// However the second photo is turned against the first, and whatever lies in the one and not in the other.
TEST_P(OverGround, SharpPhotosShowAsMuchAsEachOther) {
  const auto [texture, yaw_rad] = GetParam();
  const Picture first = Take(texture, 0.0, 0.0, kStill);
  const Picture second = Take(texture, 12.0, yaw_rad, kStill);
  EXPECT_GT(Against(first, second), 0.45);
  EXPECT_GT(Against(second, first), 0.45);
}

TEST_P(OverGround, APhotoTakenInMotionShowsLess) {
  const auto [texture, yaw_rad] = GetParam();
  const Picture sharp = Take(texture, 0.0, 0.0, kStill);
  for (const Eigen::Vector3d& motion_m : {Eigen::Vector3d(0.8, 0.0, 0.0), Eigen::Vector3d(-0.4, 0.7, 0.0)}) {
    const Picture blurred = Take(texture, 12.0, yaw_rad, motion_m);
    EXPECT_LT(Against(blurred, sharp), 0.35);
    EXPECT_GT(Against(sharp, blurred), 0.9);
  }
}

INSTANTIATE_TEST_SUITE_P(OfAllKinds, OverGround,
                         testing::Combine(testing::Values(simulate::TextureLevel::kRich,
                                                          simulate::TextureLevel::kRows,
                                                          simulate::TextureLevel::kBare),
                                          testing::Values(0.0, 0.5 * geo::kPi, 2.4)));

TEST(SharpnessAgainst, SaysNothingOfPhotosThatShareNothing) {
  const Picture here = Take(simulate::TextureLevel::kRich, 0.0, 0.0, kStill);
  const Picture there = Take(simulate::TextureLevel::kRich, 500.0, 0.0, kStill);
  EXPECT_FALSE(SharpnessAgainst(here.detail, here.view, there.detail, there.view, Relief(0.0)).has_value());
}

TEST(SharpnessAgainst, SaysNothingFromDistancesTooDifferent) {
  Picture near = Take(simulate::TextureLevel::kRich, 0.0, 0.0, kStill);
  Picture far = near;
  far.view.cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(far.view.cam_from_enu.rotation, {0.0, 0.0, 2.0 * kLowHeightM});
  EXPECT_FALSE(SharpnessAgainst(near.detail, near.view, far.detail, far.view, Relief(0.0)).has_value());
}

TEST(MeasureDetail, OfAPictureTooSmallIsEmpty) {
  const std::vector<std::uint8_t> grey(16 * 16, 100);
  EXPECT_TRUE(MeasureDetail(16, 16, grey.data()).empty());
  EXPECT_EQ(SharpnessByItself({}), 0.0);
}

}  // namespace
}  // namespace skyquilt::alignment
