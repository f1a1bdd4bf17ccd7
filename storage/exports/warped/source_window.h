// SourceWindow: a rectangle of one zoom's pixels, decoded from the tiles that lie below it. LoadWindow runs
// on any thread. Errors: kCorrupt, those of the tileset.
#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/image/rgba_image.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// A zoom's pixels: columns from the antimeridian in the west, and on beyond it in the east; rows from the
// north.
struct SourceLevel {
  int zoom = 0;
  int tile_size_px = 256;
};

struct SourceWindow {
  std::int64_t left_px = 0, top_px = 0;
  image::RgbaImage pixels;  // straight alpha; transparent where there is no tile
};

Result<SourceWindow> LoadWindow(MapTiles& tiles, const SourceLevel& level, std::int64_t left_px,
                                std::int64_t top_px, int width_px, int height_px);

}  // namespace skyquilt::storage
