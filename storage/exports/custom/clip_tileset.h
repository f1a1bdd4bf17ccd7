// ClipTileset: of a finished MBTiles the tiles that lie within a boundary, down to a zoom, as another one.
// Tiles wholly within are copied byte for byte; those on the boundary are made transparent beyond it and
// encoded anew. Streams; memory is one tile and the boundary. Published by rename. Blocking. Errors:
// kUnprocessable (nothing is left), kIo, kOutOfSpace, kCorrupt, kCancelled.
#pragma once

#include <filesystem>
#include <limits>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/exports/custom/boundary.h"

namespace skyquilt::storage {

struct ClipOptions {
  const Boundary* boundary = nullptr;  // none: the whole map
  int max_zoom = std::numeric_limits<int>::max();
  int quality = 85;
};

Result<void> ClipTileset(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                         const ClipOptions& options, Progress& progress);

}  // namespace skyquilt::storage
