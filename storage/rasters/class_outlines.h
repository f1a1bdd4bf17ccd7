// A grid of classes (zones of a field) as outlines: one feature for each class, polygons in longitude and
// latitude, as GeoJSON or as a zipped shapefile, which machines on fields read. Edges follow the cells, and
// no polygon crosses the antimeridian: it ends there and goes on at the other side. Any thread; takes a
// second for four million cells. Memory: 40 bytes a cell. Errors: kUnprocessable (more than kMaxParts
// separate parts; the message says what to do), kInternal (GDAL would not).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/rasters/band_raster.h"

namespace skyquilt::storage {

struct ClassGrid {
  MercGrid grid;
  std::vector<std::uint8_t> classes;  // from 1, rows from the north; 0: none
};

// Patches of fewer cells than these become part of their largest neighbour.
Result<void> SieveClasses(ClassGrid& grid, int min_cells);

struct ClassFacts {
  double min = 0.0, max = 0.0, mean = 0.0;  // of its values
  double area_m2 = 0.0;
};
enum class OutlineFormat { kGeoJson, kShapefile };

inline constexpr int kMaxParts = 50'000;

// `facts`: of class 1, 2 ...; they become the fields zone, min, max, mean, area_m2.
Result<std::string> OutlineClasses(const ClassGrid& grid, std::span<const ClassFacts> facts,
                                   OutlineFormat format);

}  // namespace skyquilt::storage
