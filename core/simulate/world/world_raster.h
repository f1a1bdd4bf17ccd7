// The truth as a map: the simulated world seen from straight above, and how high it is, as tiled GeoTIFFs in
// EPSG:3857 whose pixels are those of the Web Mercator tiles of one zoom. Made tile by tile: bounded memory,
// any size. Errors: kIo, kCancelled.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/geo/bounds.h"
#include "core/geo/local_frame.h"
#include "core/geo/raster_frame.h"
#include "core/image/decoded_image.h"
#include "core/simulate/world/world.h"

namespace skyquilt::simulate {

inline constexpr int kWorldTilePx = 256;

// The raster of whole tiles of `zoom` that covers these bounds.
geo::RasterFrame WorldRasterFrame(const geo::Bounds2& bounds_in_merc, int zoom);

// The truth of any raster in merc, for tests and for the files below.
image::DecodedImage RenderWorld(const World& world, const geo::LocalFrame& frame,
                                const geo::RasterFrame& raster);
// Three samples a pixel, by rows: heights over the WGS84 ellipsoid of the surface that one sees from above
// and of the terrain below it, in metres, and which of world.objects() that surface is, from 1; 0 = ground,
// -1 = water.
std::vector<float> SurfaceOf(const World& world, const geo::LocalFrame& frame,
                             const geo::RasterFrame& raster);

Result<void> WriteWorldGeoTiff(const World& world, const geo::LocalFrame& frame,
                               const geo::RasterFrame& raster, int threads, const std::filesystem::path& path,
                               Progress& progress);
// The samples of SurfaceOf as three bands of float32.
Result<void> WriteSurfaceGeoTiff(const World& world, const geo::LocalFrame& frame,
                                 const geo::RasterFrame& raster, int threads,
                                 const std::filesystem::path& path, Progress& progress);

}  // namespace skyquilt::simulate
