// SeamShift: how far the two photos that meet at a seam show things apart, on the ground in metres, over the
// patches that were looked at. A value; any thread.
#pragma once

namespace skyquilt::render {

struct SeamShift {
  int patches = 0;   // looked at
  int reliable = 0;  // of those: alike once shifted
  double gsd_m = 0.0;
  double median_m = 0.0;
  double p90_m = 0.0;
};

}  // namespace skyquilt::render
