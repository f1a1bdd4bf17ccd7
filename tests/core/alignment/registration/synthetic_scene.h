// Photos of a made-up ground as features alone, with known poses: what registration is tested on without
// pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/registration.h"
#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

struct SyntheticOptions {
  int columns = 6, rows = 4;
  double step_m = 12.0;
  double height_m = 50.0;
  double relief_m = 2.0;
  double tilt_rad = 0.05;         // each camera's lean, in a random direction
  bool any_yaw = false;           // else along the line, turned round on the next
  double climb_from_share = 1.0;  // the first photo's height; grows to all of it along the flight
  double noise_px = 0.7;
  double points_per_m2 = 0.35;
  double lost_share = 0.3;  // of points a photo does not find
  std::uint64_t seed = 1;
};

struct SyntheticScene {
  camera::Intrinsics lens;
  std::vector<geo::Rigid3> cam_from_enu;
  std::vector<PhotoFeatures> features;
};

SyntheticScene MakeScene(const SyntheticOptions& options);

// Without positions; `focal_factor` is what the lens is mistaken by.
Registration InputOf(const SyntheticScene& scene, double focal_factor = 1.0);

}  // namespace skyquilt::alignment
