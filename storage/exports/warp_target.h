// WarpTarget: the system and pixels that a map's raster is brought to, be it of colours (warped/warp_tiles.h)
// or of values (warp_geotiff.h). A value; any thread.
#pragma once

namespace skyquilt::storage {

struct WarpTarget {
  int epsg = 3857;
  double pixel_x = 1.0, pixel_y = 1.0;  // in units of that system
  bool is_coarser = false;              // than what is read
};

}  // namespace skyquilt::storage
