// RenderWarpedWindow: a window of a map in another coordinate system, whose rows and columns do not run along
// the tiles. Where its pixels lie is computed at the corners, sides and middles of squares of pixels and
// between them bilinearly, unless that is off by more than a fiftieth of a pixel of the map: then the square
// is divided. Memory: the window, and decoded tiles up to kMaxWarpedTilesBytes (or four tiles of the largest
// kind). Any thread. Errors: kCorrupt, kIo.
#pragma once

#include <cstddef>

#include "api/tiles/map_window.h"

namespace skyquilt::api {

inline constexpr std::size_t kMaxWarpedTilesBytes = std::size_t{64} << 20;

// Precondition: the window has merc_of. `zoom`: the one that is read.
Result<image::RgbaImage> RenderWarpedWindow(const storage::Tileset& tileset, int zoom,
                                            const MapWindow& window);

}  // namespace skyquilt::api
