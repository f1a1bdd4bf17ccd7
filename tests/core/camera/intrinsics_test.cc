#include "core/camera/intrinsics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/camera/fit_fisheye.h"
#include "tests/support/value_of.h"

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
      EXPECT_LT((test::ValueOf(camera.Project(7.0 * camera.Unproject(pixel))) - pixel).norm(), 1e-8);
    }
  }
}

TEST(Intrinsics, RefusesRaysBehindTheCameraAndBeyondTheFold) {
  EXPECT_FALSE(BentCamera().Project({0.0, 0.0, -1.0}).has_value());
  // k1 = -0.5 alone folds at r^2 = 2/3: a ray further out would land inside the image again.
  Intrinsics folding = Intrinsics::Centered(1000, 1000, 800.0);
  folding.k1 = -0.5;
  EXPECT_NEAR(folding.MaxRadiusSquared(), 2.0 / 3.0, 1e-9);
  EXPECT_FALSE(folding.Project({1.3, 0.0, 1.0}).has_value());
  EXPECT_TRUE(folding.Project({0.5, 0.0, 1.0}).has_value());
}

// Our lens model fitted to calibrated fisheyes, and to what is none.

// Of a Parrot Sequoia's green camera.
FisheyeLens Sequoia() {
  FisheyeLens lens;
  lens.px_per_right_angle_x = lens.px_per_right_angle_y = 1676.825547;
  lens.polynomial = {0.0, 1.0, 0.00592627, -0.136981656, 0.0};
  lens.center_x_px = 2.487934 * 266.6666559 - 0.5;
  lens.center_y_px = 1.754932 * 266.6666559 - 0.5;
  return lens;
}

TEST(FitFisheye, SeesTheSameOverTheWholePicture) {
  const FisheyeLens fisheye = Sequoia();
  const auto fitted = test::ValueOf(FitFisheye(fisheye, 1280, 960));
  // Its even term has no counterpart in our model.
  EXPECT_LT(fitted.worst_px, 0.3);
  for (const double angle : {0.05, 0.2, 0.4, 0.6}) {
    for (const double around : {0.0, 0.7, 2.0, 4.0}) {
      const double theta = 2.0 / std::numbers::pi * angle;
      const double rho = theta + 0.00592627 * theta * theta - 0.136981656 * theta * theta * theta;
      const auto pixel = fitted.lens.Project(
          {std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle)});
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), fisheye.center_x_px + 1676.825547 * rho * std::cos(around), 0.3);
      EXPECT_NEAR(pixel->y(), fisheye.center_y_px + 1676.825547 * rho * std::sin(around), 0.3);
    }
  }
}

// As Parrot documents that of an ANAFI Ai.
TEST(FitFisheye, CountsThePolynomialsFifthNumber) {
  FisheyeLens fisheye;
  fisheye.px_per_right_angle_x = fisheye.px_per_right_angle_y = 10858.1;
  fisheye.polynomial = {0.0, 1.0, 0.1542, -0.7726, 0.2407};
  fisheye.center_x_px = 3999.5;
  fisheye.center_y_px = 2999.5;
  const auto fitted = test::ValueOf(FitFisheye(fisheye, 8000, 6000));
  for (const double angle : {0.2, 0.5, 0.7}) {
    const double theta = 2.0 / std::numbers::pi * angle;
    const double rho = theta * (1.0 + theta * (0.1542 + theta * (-0.7726 + theta * 0.2407)));
    const auto pixel = test::ValueOf(fitted.lens.Project({std::sin(angle), 0.0, std::cos(angle)}));
    EXPECT_NEAR(pixel.x(), 3999.5 + 10858.1 * rho, 6.0);
  }
}

TEST(FitFisheye, RefusesWhatIsNoLens) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(FitFisheye(Sequoia(), 0, 960));
  for (const double scale : {0.0, -5.0, nan, 1.0}) {
    FisheyeLens lens = Sequoia();
    lens.px_per_right_angle_x = scale;
    EXPECT_FALSE(FitFisheye(lens, 1280, 960)) << scale;
  }
  for (const std::array<double, 5>& polynomial : {std::array<double, 5>{0.0, 0.0, 0.0, 0.0, 0.0},
                                                  {0.0, 1.0, -5.0, 0.0, 0.0},
                                                  {0.0, 1.0, 0.0, 0.0, -50.0},
                                                  {0.0, nan, 0.0, 0.0, 0.0},
                                                  {1.0, 1.0, 0.0, 0.0, 0.0}}) {
    FisheyeLens lens = Sequoia();
    lens.polynomial = polynomial;
    EXPECT_FALSE(FitFisheye(lens, 1280, 960));
  }
  FisheyeLens aside = Sequoia();
  aside.center_x_px = 5000.0;
  EXPECT_FALSE(FitFisheye(aside, 1280, 960));
}

}  // namespace
}  // namespace skyquilt::camera
