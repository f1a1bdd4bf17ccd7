// WriteSurface: the heights of a map that was just made, dsm.tif, dsm_photos.tif and dsm_hillshade.tif in its
// folder, where options.heights says so also dtm.tif, dtm_ground.tif and the contours of that, and what came
// of them in its report, also why there are none (beyond UTM, fields far apart). Over the rectangle around
// the map, also where that is cut to a boundary. Blocking; uses all the threads asked for. Errors:
// kCancelled, kOutOfSpace, kIo.
#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/pipeline/build_mosaic.h"

namespace skyquilt::server {

Result<void> WriteSurface(pipeline::BuiltMosaic& built, const pipeline::MosaicOptions& options,
                          const flight::PhotoSource& photos, const std::filesystem::path& out_dir,
                          Progress& progress);

}  // namespace skyquilt::server
