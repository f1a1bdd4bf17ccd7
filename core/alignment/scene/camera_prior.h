// A lens as recorded and as adjusted, and how far the record holds it. A value; any thread.
#pragma once

#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

struct BundleLens {
  camera::Intrinsics recorded;    // the prior
  camera::Intrinsics intrinsics;  // in: start; out: adjusted
  double sigma_focal_share = 0.01;
  double sigma_center_px = 10.0;
  double sigma_k1 = 0.05;
  double sigma_k2 = 0.05;
  double sigma_p = 0.001;
  bool is_fixed = false;
  // The time from the first row of a picture to the last is an unknown of the adjustment: of photos that have
  // a velocity and no doubts, whose motion it becomes.
  bool finds_readout = false;
  double readout_s = 0.0;  // in: start; out: adjusted
  double sigma_readout_s = 0.05;
  double found_sigma_focal_px = 0.0;  // out: what the images left of the prior
};

}  // namespace skyquilt::alignment
