// WriteHillshade: slopes of a raster of heights (dsm.tif) lit from four sides of the sky, as a picture to lay
// below lines and labels: dsm_hillshade.tif beside it, a cloud-optimised GeoTIFF of one byte a cell on the
// same cells, 0 where there is no height. The same bytes for the same raster. Memory: a few rows. Blocking.
// Errors: kIo, kOutOfSpace, kCancelled. Source: gdaldem (USGS' multidirectional shading, Mark 1992).
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::storage {

// `threads`: 0 = all cores, for what is compressed.
Result<void> WriteHillshade(const std::filesystem::path& heights, int threads, Progress& progress);

}  // namespace skyquilt::storage
