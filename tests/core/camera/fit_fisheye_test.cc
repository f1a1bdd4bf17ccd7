// Our lens model fitted to calibrated fisheyes, and to what is none.
#include "core/camera/fit_fisheye.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace skyquilt::camera {
namespace {

// Of a Parrot Sequoia's green camera.
FisheyeLens Sequoia() {
  FisheyeLens lens;
  lens.px_per_right_angle_x = lens.px_per_right_angle_y = 1676.825547;
  lens.polynomial = {0.0, 1.0, 0.00592627, -0.136981656};
  lens.center_x_px = 2.487934 * 266.6666559 - 0.5;
  lens.center_y_px = 1.754932 * 266.6666559 - 0.5;
  return lens;
}

TEST(FitFisheye, SeesTheSameOverTheWholePicture) {
  const FisheyeLens fisheye = Sequoia();
  const auto fitted = FitFisheye(fisheye, 1280, 960);
  ASSERT_TRUE(fitted.has_value());
  // Its even term has no counterpart in our model.
  EXPECT_LT(fitted->worst_px, 0.3);
  for (const double angle : {0.05, 0.2, 0.4, 0.6}) {
    for (const double around : {0.0, 0.7, 2.0, 4.0}) {
      const double theta = 2.0 / std::numbers::pi * angle;
      const double rho = theta + 0.00592627 * theta * theta - 0.136981656 * theta * theta * theta;
      const auto pixel = fitted->lens.Project(
          {std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle)});
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), fisheye.center_x_px + 1676.825547 * rho * std::cos(around), 0.3);
      EXPECT_NEAR(pixel->y(), fisheye.center_y_px + 1676.825547 * rho * std::sin(around), 0.3);
    }
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
  for (const std::array<double, 4>& polynomial : {std::array<double, 4>{0.0, 0.0, 0.0, 0.0},
                                                  {0.0, 1.0, -5.0, 0.0},
                                                  {0.0, nan, 0.0, 0.0},
                                                  {1.0, 1.0, 0.0, 0.0}}) {
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
