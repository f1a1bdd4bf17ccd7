// The directories of a PMTiles archive: which tile lies where. Pure. Source: PMTiles specification version 3,
// chapters 3.3 (tile numbers) and 4 (directories).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/geo/tile_id.h"

namespace skyquilt::storage {

// The tile's number along the Hilbert curves of all zooms, coarsest first.
std::uint64_t PmtilesNumber(const geo::TileId& tile);

struct PmtilesEntry {
  std::uint64_t tile = 0;
  std::uint64_t offset = 0;  // in the section of tiles
  std::uint32_t length = 0;
  std::uint32_t run = 1;  // so many tiles in a row share the bytes
};

struct PmtilesDirectories {
  std::string root;    // at most kPmtilesRootBytes
  std::string leaves;  // empty when the root holds everything
};

inline constexpr std::size_t kPmtilesHeaderBytes = 127;
// The root must lie within the first 16 KiB of the file.
inline constexpr std::size_t kPmtilesRootBytes = 16384 - kPmtilesHeaderBytes;

// Entries by rising tile number.
PmtilesDirectories MakePmtilesDirectories(const std::vector<PmtilesEntry>& entries);

}  // namespace skyquilt::storage
