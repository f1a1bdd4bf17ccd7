// RenderWindow: any window of a tileset as pixels, at any size: what WMS, OGC API Maps, tiles of other grids
// and 512-pixel tiles need. Bilinear with premultiplied alpha; where the window's pixels are the map's own,
// their values are exactly those of the tiles. Memory: the window and one row of tiles, up to the budget; of
// a window in another coordinate system, decoded tiles up to 64 MiB or four of the largest kind. Any thread.
// Errors: kTooLarge (beyond the budget), kCorrupt, kIo.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "core/image/rgba_image.h"
#include "storage/caches/tileset_cache.h"

namespace skyquilt::api {

struct MapWindow {
  int width_px = 0;
  int height_px = 0;
  // merc coordinates of pixel centres: columns go from west to east, rows from north to south.
  std::function<double(int column)> x_in_merc;
  std::function<double(int row)> y_in_merc;
  double pixel_m = 1.0;  // in merc; chooses the zoom
  // Of a window whose rows and columns do not run along merc, instead of the two above: the merc coordinates
  // of a place counted in pixels from the upper left corner, so that the middle of the first one is at 0.5,
  // 0.5. Not a number where the window shows no place on Earth.
  std::function<Eigen::Vector2d(double column, double row)> merc_of = nullptr;
};

// One pixel: the one of the finest zoom that a place lies in.
MapWindow WindowOfFinestPixel(const storage::Tileset& tileset, const Eigen::Vector2d& merc);
MapWindow WindowOfTile(const geo::TileId& tile, int side_px);

// What a window may take of a map. One with overviews needs a hundredth of it; a picture of all of one of a
// single zoom, as others make them, would be made of each of its tiles.
struct TileBudget {
  std::size_t kept_bytes = std::size_t{1} << 30;    // of decoded tiles; what is forgotten is decoded anew
  std::int64_t decoded_px = std::int64_t{1} << 32;  // over all tiles
};

Result<image::RgbaImage> RenderWindow(const storage::Tileset& tileset, const MapWindow& window,
                                      const TileBudget& budget = {});

}  // namespace skyquilt::api
