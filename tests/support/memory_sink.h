// MemorySink: tiles kept in memory, for tests that look at pixels.
#pragma once

#include <map>
#include <vector>

#include "core/pyramid/tile_sink.h"

namespace skyquilt::test {

struct StoredTile {
  image::PictureFormat format;
  std::vector<std::uint8_t> bytes;
  bool operator==(const StoredTile&) const = default;
};

class MemorySink final : public pyramid::TileSink {
 public:
  Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                   std::span<const std::uint8_t> bytes) override {
    tiles[tile] = {format, {bytes.begin(), bytes.end()}};
    order.push_back(tile);
    return {};
  }
  std::map<geo::TileId, StoredTile> tiles;
  std::vector<geo::TileId> order;
};

}  // namespace skyquilt::test
