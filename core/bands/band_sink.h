// BandSink: the port through which the renderer hands over a raster of bands, block by block. Web Mercator
// (EPSG:3857), north up, pixels square; the raster's grid is the web map's own at its zoom.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::bands {

struct RasterBand {
  std::string name;
  double wavelength_nm = 0.0;  // 0: not known
  double width_nm = 0.0;       // full width at half maximum; 0: not known
  std::string calibration;     // what its values are
  std::string method;
};

struct BandRaster {
  double west_in_merc_m = 0.0;
  double north_in_merc_m = 0.0;
  double pixel_in_merc_m = 1.0;
  int width_px = 0;
  int height_px = 0;
  int block_px = 0;  // blocks come as squares of this side
  std::vector<RasterBand> bands;
};

class BandSink {
 public:
  virtual ~BandSink() = default;
  // Once, before any block.
  virtual Result<void> Begin(const BandRaster& raster) = 0;
  // The block whose first pixel is (left_px, top_px): values by band, row by row; NaN where nothing is known.
  virtual Result<void> Put(int left_px, int top_px, const std::vector<std::vector<float>>& values) = 0;
};

}  // namespace skyquilt::bands
