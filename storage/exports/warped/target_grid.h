// TargetGrid: the pixels of a GeoTIFF in some coordinate system that covers a part of a web map, north up,
// and where they lie in the web map's. Any thread; the places are asked of PROJ by one thread at a time.
// Errors: kUnprocessable (a system that PROJ does not lead to, or in which the map would be too large).
#pragma once

#include <ogr_spatialref.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "storage/exports/tiff_head.h"

namespace skyquilt::storage {

class TargetGrid {
 public:
  // Whole pixels that cover the bounds, whichever way their edges bend. `pixel_x`, `pixel_y`: in units of the
  // system.
  static Result<std::unique_ptr<TargetGrid>> Cover(const geo::LatLonBounds& bounds, int epsg, double pixel_x,
                                                   double pixel_y);

  // Nothing leads there, or not with so many pixels.
  static Error Unreachable(int epsg);

  std::int64_t width_px() const { return width_px_; }
  std::int64_t height_px() const { return height_px_; }
  TiffPlace place() const;
  // How many metres of Web Mercator a pixel spans, about its middle.
  double PixelInMercM() const { return pixel_in_merc_m_; }
  // In Web Mercator: of the corners of squares of `step_px`, `columns` by `rows` of them row by row from the
  // corner at (left_px, top_px); no numbers where a place is none on Earth, as beyond the grid it may be.
  // Eastings go on beyond the date line as the bounds do.
  std::vector<Eigen::Vector2d> CornersInMerc(std::int64_t left_px, std::int64_t top_px, int step_px,
                                             int columns, int rows) const;

 private:
  TargetGrid() = default;

  OGRSpatialReference system_;
  std::string name_;
  int epsg_ = 0;
  double west_ = 0.0, north_ = 0.0, pixel_x_ = 1.0, pixel_y_ = 1.0;
  std::int64_t width_px_ = 0, height_px_ = 0;
  double middle_in_merc_m_ = 0.0;  // easting
  double pixel_in_merc_m_ = 0.0;
  mutable std::mutex mutex_;
  std::unique_ptr<OGRCoordinateTransformation> merc_from_target_;
};

}  // namespace skyquilt::storage
