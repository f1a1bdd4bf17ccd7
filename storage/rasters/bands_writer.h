// BandsWriter: a raster of bands as a cloud-optimised GeoTIFF (bands.tif): float32, NaN where nothing is
// known, in EPSG:3857 on the web map's own pixels, with overviews, by GDAL. Each band is described by its
// name (green, red, rededge, nir) and carries what is known of it: WAVELENGTH and FWHM in WAVELENGTH_UNITS
// (nm), CALIBRATION and METHOD. Scale 1, offset 0. Blocks go to a temporary file beside the outcome as they
// come (compressed without loss), which becomes a COG of the covered part on Publish. Memory: GDAL's block
// cache. One thread. Errors: kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>
#include <memory>

#include "core/bands/band_sink.h"
#include "core/base/progress.h"

namespace skyquilt::storage {

class BandsWriter final : public bands::BandSink {
 public:
  // `threads`: 0 = all cores.
  BandsWriter(std::filesystem::path path, int threads, Progress& progress);
  ~BandsWriter() override;

  Result<void> Begin(const bands::BandRaster& raster) override;
  Result<void> Put(int left_px, int top_px, const std::vector<std::vector<float>>& values) override;
  // After the last block. Writes no file where no pixel has a value.
  Result<void> Publish();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace skyquilt::storage
