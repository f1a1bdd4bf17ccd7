// WriteIndexGrid: an index of a map's bands (core/indices) as a GeoTIFF of one band: float32, NaN where it
// has no value, in EPSG:3857 on the map's own pixels, described by the index's name or formula. The bands are
// those of bands.tif, or the map's own colours, 0 to 1, where it has none. Tile by tile; memory: a tile and
// GDAL's block cache. Tiled and compressed without loss, but not cloud-optimised: a step on the way
// (warp_geotiff.h). Blocking; one thread. Errors: kInvalidArgument (as PlacesOf), kUnprocessable (nothing
// within the boundary), kCorrupt, kIo, kOutOfSpace, kCancelled.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/indices/band_expression.h"
#include "storage/exports/custom/export_request.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

struct IndexSource {
  MapTiles& tiles;
  std::filesystem::path bands;  // bands.tif; empty: the map has its colours alone
  MapFacts facts;
};

// Beyond `boundary` (null: none) nothing has a value.
Result<void> WriteIndexGrid(const IndexSource& source, const indices::BandExpression& expression,
                            const std::string& name, const Boundary* boundary,
                            const std::filesystem::path& path, Progress& progress);

}  // namespace skyquilt::storage
