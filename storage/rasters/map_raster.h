// MapRaster: a georeferenced GeoTIFF of others (8 bits; grey, palette, RGB, with or without alpha, mask or
// "no data") seen on the tiles of the web map: warped by GDAL to Web Mercator, block by block. Memory: GDAL's
// block cache and warp buffer, whatever the file's size. Foreign bytes: not for processes that serve others.
// One thread. Errors: kNotFound, kUnsupportedFormat (no GeoTIFF; other pixels), kUnprocessable (it does not
// say where it lies, or lies where there are no tiles), kTooLarge, kCorrupt (damaged). The message says what
// to do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/image/rgba_image.h"

namespace skyquilt::storage {

class MapRaster {
 public:
  static constexpr int kUsualTileSizePx = 256;
  static constexpr std::int64_t kMaxTiles = 2'000'000;  // of the finest zoom

  // `name`: what errors call the file.
  static Result<std::unique_ptr<MapRaster>> Open(const std::filesystem::path& path, const std::string& name);
  ~MapRaster();

  // The coarsest zoom whose pixels are not larger than the raster's; beyond zoom 22 tiles grow instead.
  int zoom() const { return zoom_; }
  int tile_size_px() const { return tile_size_px_; }
  double pixel_m() const { return pixel_m_; }  // of the raster, on the ground, in its middle
  const geo::LatLonBounds& bounds() const { return bounds_; }
  // Columns and rows of the tiles that it may cover, from the north; the last ones included.
  int first_column() const { return first_column_; }
  int last_column() const { return last_column_; }
  int first_row() const { return first_row_; }
  int last_row() const { return last_row_; }

  // Pixels with premultiplied alpha, from the north-west corner of a tile of zoom() on, so many tiles wide
  // and high; transparent beyond the raster.
  Result<image::RgbaImage> Read(int column, int row, int columns, int rows);

 private:
  struct Dataset;
  explicit MapRaster(std::unique_ptr<Dataset> dataset);
  std::unique_ptr<Dataset> dataset_;
  int zoom_ = 0;
  int tile_size_px_ = kUsualTileSizePx;
  double pixel_m_ = 0.0;
  geo::LatLonBounds bounds_;
  int first_column_ = 0, last_column_ = 0, first_row_ = 0, last_row_ = 0;
};

}  // namespace skyquilt::storage
