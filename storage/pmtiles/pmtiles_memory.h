// PmtilesMemory: what all maps that are open share of memory: directories and tiles. Any thread.
#pragma once

#include <cstddef>
#include <vector>

#include "storage/blobs/lru_memory.h"
#include "storage/pmtiles/pmtiles_directory.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {

struct PmtilesMemory {
  static constexpr std::size_t kUsualLeafBytes = std::size_t{64} << 20;
  static constexpr std::size_t kUsualTileBytes = std::size_t{64} << 20;

  explicit PmtilesMemory(std::size_t leaf_bytes = kUsualLeafBytes, std::size_t tile_bytes = kUsualTileBytes)
      : leaves(leaf_bytes), tiles(tile_bytes) {}

  LruMemory<std::vector<PmtilesEntry>> leaves;  // unpacked
  LruMemory<FoundTile> tiles;                   // with their bytes
};

}  // namespace skyquilt::storage
