// TileSink: the port through which finished tiles leave the core. Implemented by storage.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"

namespace skyquilt::pyramid {

class TileSink {
 public:
  virtual ~TileSink() = default;
  // Takes one encoded tile. Called by one thread at a time, in an order that does not depend on threads.
  virtual Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                           std::span<const std::uint8_t> bytes) = 0;
};

}  // namespace skyquilt::pyramid
