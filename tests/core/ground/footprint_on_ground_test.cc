#include "core/ground/footprint_on_ground.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/camera/footprint.h"

namespace skyquilt::ground {
namespace {

camera::Intrinsics Lens() {
  camera::Intrinsics lens;
  lens.width_px = 400;
  lens.height_px = 300;
  lens.focal_x_px = lens.focal_y_px = 300.0;
  lens.center_x_px = 199.5;
  lens.center_y_px = 149.5;
  return lens;
}

// Looks straight down from 60 m, leaning by `tilt_rad` to the side.
geo::Rigid3 Camera(double tilt_rad) {
  const Eigen::Quaterniond cam_from_enu(Eigen::AngleAxisd(M_PI + tilt_rad, Eigen::Vector3d::UnitX()));
  return geo::Rigid3::FromRotationAndTargetOrigin(cam_from_enu, {5.0, -3.0, 60.0});
}

// Gentle waves of 8 m.
GroundSurface Hills() {
  constexpr int kCells = 121;
  std::vector<float> heights;
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      heights.push_back(static_cast<float>(4.0 * std::sin(column / 9.0) + 4.0 * std::cos(row / 11.0)));
    }
  }
  return GroundSurface::Grid({-60.0, -60.0}, 1.0, kCells, kCells, heights, 0.0);
}

TEST(FootprintOnGround, ProjectsBackToTheImageBorder) {
  const GroundSurface hills = Hills();
  const camera::Intrinsics lens = Lens();
  for (const double tilt_rad : {0.0, 0.2, -0.3}) {
    const geo::Rigid3 cam_from_enu = Camera(tilt_rad);
    const auto polygon = FootprintOnGround(hills, lens, cam_from_enu, 6);
    ASSERT_EQ(polygon.size(), 24u);
    for (const Eigen::Vector2d& point : polygon) {
      const Eigen::Vector3d in_cam =
          cam_from_enu * Eigen::Vector3d(point.x(), point.y(), hills.HeightAt(point));
      const double x = lens.center_x_px + lens.focal_x_px * in_cam.x() / in_cam.z();
      const double y = lens.center_y_px + lens.focal_y_px * in_cam.y() / in_cam.z();
      const double to_border =
          std::min({std::abs(x + 0.5), std::abs(x - 399.5), std::abs(y + 0.5), std::abs(y - 299.5)});
      EXPECT_LT(to_border, 0.05) << x << " " << y << " tilt " << tilt_rad;
    }
  }
}

TEST(FootprintOnGround, IsTheFlatOneOnAPlane) {
  const auto flat = camera::GroundFootprint(Lens(), Camera(0.1), 2.0, 8);
  const auto found = FootprintOnGround(GroundSurface::Plane(2.0), Lens(), Camera(0.1), 8);
  ASSERT_EQ(found.size(), flat.size());
  for (std::size_t i = 0; i < flat.size(); ++i) EXPECT_LT((found[i] - flat[i]).norm(), 1e-9);
}

TEST(FootprintOnGround, IsEmptyForAPhotoOfTheSky) {
  EXPECT_TRUE(FootprintOnGround(Hills(), Lens(), Camera(0.8 * M_PI), 8).empty());
  EXPECT_FALSE(FootprintOnGround(Hills(), Lens(), Camera(M_PI / 2), 8).empty())
      << "below the horizon is ground";
}

}  // namespace
}  // namespace skyquilt::ground
