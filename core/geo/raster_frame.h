// RasterFrame: where the pixels of a north-up raster lie in `merc`. The half pixel between pixel centres and
// pixel corners is applied here and nowhere else: pixel (0,0) is the CENTRE of the north-west pixel.
// A value; any thread.
#pragma once

#include <Eigen/Core>

#include "core/geo/bounds.h"
#include "core/geo/tile_id.h"

namespace skyquilt::geo {

struct RasterFrame {
  Eigen::Vector2d north_west_in_merc = Eigen::Vector2d::Zero();  // outer corner
  double pixel_size_in_merc_m = 1.0;
  int width_px = 0;
  int height_px = 0;

  Eigen::Vector2d MercFromPixel(const Eigen::Vector2d& pixel_in_raster) const {
    return {north_west_in_merc.x() + (pixel_in_raster.x() + 0.5) * pixel_size_in_merc_m,
            north_west_in_merc.y() - (pixel_in_raster.y() + 0.5) * pixel_size_in_merc_m};
  }
  Bounds2 BoundsInMerc() const {
    Bounds2 bounds;
    bounds.Include(north_west_in_merc);
    bounds.Include(Eigen::Vector2d(north_west_in_merc.x() + width_px * pixel_size_in_merc_m,
                                   north_west_in_merc.y() - height_px * pixel_size_in_merc_m));
    return bounds;
  }
  // The raster of one tile, cut into size_px pixels a side.
  static RasterFrame OfTile(const TileId& tile, int size_px) {
    const Bounds2 bounds = tile.BoundsInMerc();
    return {{bounds.min.x(), bounds.max.y()}, TileSizeInMercM(tile.z()) / size_px, size_px, size_px};
  }
};

}  // namespace skyquilt::geo
