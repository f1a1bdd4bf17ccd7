// WriteKmz: a finished MBTiles as a KMZ super-overlay for Google Earth and its like: the same tiles (but
// WebP, which KML viewers do not show: PNG of those with alpha, JPEG of the others), each with a small KML
// that leads to the finer ones, loaded as the viewer comes near. Streams: one tile in memory. Published by
// rename. Blocking. Errors: kIo, kOutOfSpace, kCorrupt, kCancelled. Source: OGC KML 2.3, Region and
// NetworkLink.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::storage {

Result<void> WriteKmz(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                      Progress& progress);

}  // namespace skyquilt::storage
