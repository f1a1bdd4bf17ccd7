// BandRaster: the bands of a map (bands.tif beside its tiles), read at any grid of Web Mercator. The file is
// one that this program made: a cloud-optimised GeoTIFF in EPSG:3857 on the map's own pixels, its bands named
// by their descriptions in lower case (green, red, nir ...), whose values are floats with NaN, or whole
// numbers with scale and offset, where nothing is known. Coarser grids come from its overviews, averaged over
// what is known; at the map's own pixels values are exactly those of the file.
//
// Any thread. Memory: GDAL's block cache and what is read. Errors: kCorrupt (no such file of ours),
// kInvalidArgument (a grid beyond kMaxSidePx).
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/geo/bounds.h"
#include "core/indices/band_expression.h"
#include "storage/rasters/geotiff_pool.h"
#include "storage/rasters/merc_grid.h"

namespace skyquilt::storage {

// Of a map without bands.tif: its colours, 0 to 1.
const std::vector<std::string>& ColourBands();
// Where the bands that an expression reads stand among those that there are. Error: kInvalidArgument (one is
// not).
Result<std::vector<std::size_t>> PlacesOf(const indices::BandExpression& expression,
                                          const std::vector<std::string>& bands);

class BandRaster {
 public:
  static constexpr int kMaxBands = 32;
  static constexpr int kMaxSidePx = 8192;  // of what is read at once

  static Result<std::shared_ptr<BandRaster>> Open(const std::filesystem::path& path);

  // In the file's order.
  const std::vector<std::string>& bands() const { return bands_; }
  geo::Bounds2 BoundsInMerc() const;

  // One plane for each of `bands` (places in bands()), rows from the north; NaN where nothing is known.
  Result<std::vector<std::vector<float>>> Read(const MercGrid& grid, std::span<const std::size_t> bands);

 private:
  explicit BandRaster(std::filesystem::path path) : files_(std::move(path)) {}

  GeotiffPool files_;
  std::vector<std::string> bands_;
  std::vector<int> places_;                              // of the bands in the file, from 1
  double west_m_ = 0.0, north_m_ = 0.0, pixel_m_ = 1.0;  // merc
  int width_px_ = 0, height_px_ = 0;
};

}  // namespace skyquilt::storage
