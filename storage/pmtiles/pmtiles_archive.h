// What a PMTiles archive says of itself: its header, metadata and directories. Archives may have been changed
// by others: nothing outside the archive is pointed to, nothing unpacks to more than its bound, and entries
// are in their order. Pure. Errors: kCorrupt, kUnsupportedFormat. Source: PMTiles specification version 3,
// chapters 3 (header), 4 (directories) and 5 (metadata).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "storage/pmtiles/pmtiles_directory.h"

namespace skyquilt::storage {

struct PmtilesSection {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

struct PmtilesHeader {
  PmtilesSection root, metadata, leaves, tiles;
  int min_zoom = 0, max_zoom = 0;
  double west_deg = 0, south_deg = 0, east_deg = 0, north_deg = 0;
  std::string format;  // of its tiles, as MBTiles has it: "jpg", "png" or "webp"
};

// How much of an archive's beginning has header and root.
inline constexpr std::size_t kPmtilesHeadBytes = 16384;

Result<PmtilesHeader> ParsePmtilesHeader(std::string_view archive);
// A directory as it lies in the archive, packed. Entries with a run of zero lead to leaves.
Result<std::vector<PmtilesEntry>> ParsePmtilesDirectory(std::string_view packed);
// As MBTiles names them: name, description, attribution, tile_size, bounds, minzoom, maxzoom, format.
Result<std::map<std::string, std::string>> ParsePmtilesMetadata(std::string_view packed,
                                                                const PmtilesHeader& header);
// The entry that has this tile, or the leaf in which it is; absent: none has.
std::optional<PmtilesEntry> FindPmtilesEntry(const std::vector<PmtilesEntry>& entries, std::uint64_t tile);

}  // namespace skyquilt::storage
