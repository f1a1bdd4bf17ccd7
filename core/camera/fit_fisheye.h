// FitFisheye: our lens model for a lens that was calibrated as a fisheye: focal length and radial distortion
// chosen so that both see the same over the whole picture. Pure; any thread. Source of the fisheye model:
// Pix4D, "How are the internal and external camera parameters defined": theta = 2/pi * atan(r), rho = a
// polynomial of theta, pixels = an affine matrix times rho.
#pragma once

#include <array>
#include <optional>

#include "core/camera/intrinsics.h"

namespace skyquilt::camera {

struct FisheyeLens {
  double px_per_right_angle_x = 0.0;
  double px_per_right_angle_y = 0.0;
  std::array<double, 5> polynomial{0.0, 1.0, 0.0, 0.0, 0.0};  // of theta in right angles, constant first
  double center_x_px = 0.0;
  double center_y_px = 0.0;
};

struct FittedLens {
  Intrinsics lens;
  double worst_px = 0.0;  // the largest difference in the picture
};

// Nothing for what is no lens: sizes that are not positive, a polynomial that folds back within the picture,
// or a picture wider than 150 degrees, which our model cannot be fitted to.
std::optional<FittedLens> FitFisheye(const FisheyeLens& fisheye, int width_px, int height_px);

}  // namespace skyquilt::camera
