// RenderWindow: any window of a tileset as pixels, at any size: what WMS and 512-pixel tiles need. Bilinear
// with premultiplied alpha; where the window's pixels are the map's own, their values are exactly those of
// the tiles. Memory: the window and one row of tiles. Any thread. Errors: kCorrupt, kIo.
#pragma once

#include <functional>

#include "core/image/rgba_image.h"
#include "storage/tilesets/tileset_cache.h"

namespace skyquilt::api {

struct MapWindow {
  int width_px = 0;
  int height_px = 0;
  // merc coordinates of pixel centres: columns go from west to east, rows from north to south.
  std::function<double(int column)> x_in_merc;
  std::function<double(int row)> y_in_merc;
  double pixel_m = 1.0;  // in merc; chooses the zoom
};

Result<image::RgbaImage> RenderWindow(const storage::Tileset& tileset, const MapWindow& window);

}  // namespace skyquilt::api
