// MercGrid: pixels of Web Mercator that a raster is read at, from the north-west corner on. A value.
#pragma once

namespace skyquilt::storage {

struct MercGrid {
  double west_m = 0.0, north_m = 0.0;                // merc, of the corner of the first pixel
  double pixel_width_m = 1.0, pixel_height_m = 1.0;  // merc
  int width_px = 0, height_px = 0;
};

}  // namespace skyquilt::storage
