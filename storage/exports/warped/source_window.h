// SourceWindow: a rectangle of one zoom's pixels, decoded from the tiles that lie below it. LoadWindow runs
// on any thread. Errors: kCorrupt, those of the tileset.
#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/geo/bounds.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/image/rgba_image.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

// A zoom's pixels: columns from the antimeridian in the west, and on beyond it in the east; rows from the
// north.
struct SourceLevel {
  int zoom = 0;
  int tile_size_px = 256;
};

// A rectangle of them.
struct SourceReach {
  std::int64_t west = 0, north = 0, east = 0, south = 0;

  // What holds anything of a map.
  static SourceReach Of(const geo::LatLonBounds& bounds, double px_per_m);
  // Of these, what lies in bounds of the same pixels and `room` about them; nothing for empty bounds.
  SourceReach Within(const geo::Bounds2& bounds, double room) const;
  bool IsLargerThan(std::int64_t pixels) const;
};

struct SourceWindow {
  std::int64_t left_px = 0, top_px = 0;
  image::RgbaImage pixels;  // straight alpha; transparent where there is no tile
};

Result<SourceWindow> LoadWindow(MapTiles& tiles, const SourceLevel& level, const SourceReach& reach);

// The same, halved so often: its pixels are so much larger.
Result<SourceWindow> LoadHalved(MapTiles& tiles, const SourceLevel& level, const SourceReach& reach,
                                int halvings);

}  // namespace skyquilt::storage
