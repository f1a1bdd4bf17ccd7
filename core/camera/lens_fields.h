// VisitLensFields: the numbers of a lens, each with the name under which our JSON files have it. Any thread.
#pragma once

#include "core/camera/intrinsics.h"

namespace skyquilt::camera {

// `visit(name, value)`; the values of a lens that is not const may be set.
template <typename Lens, typename Visit>
void VisitLensFields(Lens& lens, Visit visit) {
  visit("width_px", lens.width_px);
  visit("height_px", lens.height_px);
  visit("focal_x_px", lens.focal_x_px);
  visit("focal_y_px", lens.focal_y_px);
  visit("center_x_px", lens.center_x_px);
  visit("center_y_px", lens.center_y_px);
  visit("k1", lens.k1);
  visit("k2", lens.k2);
  visit("k3", lens.k3);
  visit("p1", lens.p1);
  visit("p2", lens.p2);
}

}  // namespace skyquilt::camera
