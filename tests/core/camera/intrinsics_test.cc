#include "core/camera/intrinsics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skyquilt::camera {
namespace {

Intrinsics BentCamera() {
  Intrinsics camera = Intrinsics::Centered(4000, 3000, 2900.0);
  camera.focal_y_px = 2893.0;
  camera.center_x_px += 12.0;
  camera.center_y_px -= 21.0;
  camera.k1 = -0.21, camera.k2 = 0.09, camera.k3 = -0.02, camera.p1 = 8e-4, camera.p2 = -5e-4;
  return camera;
}

TEST(Intrinsics, ProjectUndoesUnprojectAllOverTheImage) {
  const Intrinsics camera = BentCamera();
  for (int y = 0; y < camera.height_px; y += 111) {
    for (int x = 0; x < camera.width_px; x += 111) {
      const Eigen::Vector2d pixel(x, y);
      const auto back = camera.Project(7.0 * camera.Unproject(pixel));
      ASSERT_TRUE(back.has_value());
      EXPECT_LT((*back - pixel).norm(), 1e-8);
    }
  }
}

TEST(Intrinsics, RefusesRaysBehindTheCameraAndBeyondTheFold) {
  const Intrinsics camera = BentCamera();
  EXPECT_FALSE(camera.Project({0.0, 0.0, -1.0}).has_value());
  // k1 = -0.5 alone folds at r^2 = 2/3: a ray further out would land inside the image again.
  Intrinsics folding = Intrinsics::Centered(1000, 1000, 800.0);
  folding.k1 = -0.5;
  EXPECT_NEAR(folding.MaxRadiusSquared(), 2.0 / 3.0, 1e-9);
  EXPECT_FALSE(folding.Project({1.3, 0.0, 1.0}).has_value());
  EXPECT_TRUE(folding.Project({0.5, 0.0, 1.0}).has_value());
}

}  // namespace
}  // namespace skyquilt::camera
