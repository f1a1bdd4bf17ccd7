// WriteContours: lines of equal height of a raster of heights (dtm.tif), every so many metres: contours.gpkg
// (for GIS), contours.geojson (longitude and latitude) and contours.dxf (for CAD) beside it, each line with
// its height as z and, but for DXF, as the field height_m. Heights are averaged over `smooth_m` first, over
// more where that were above four million cells; the interval is the least of 0.1, 0.2, 0.5, 1, 2, 5 ...
// metres that draws no more than kMaxContours heights. Lines of other heights go first, also where none are
// written. The same bytes for the same raster. Memory: of the averaged raster and its lines. Blocking; one
// thread. Errors: kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::storage {

inline constexpr int kMaxContours = 40;

// What lies between two lines.
double ContourIntervalM(double lowest_m, double highest_m);

// Gives the interval.
Result<double> WriteContours(const std::filesystem::path& heights, double smooth_m, Progress& progress);

}  // namespace skyquilt::storage
