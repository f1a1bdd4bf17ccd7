// What a PMTiles archive says of itself: its directories (which tile lies where), as they are written and
// read, its header and metadata as they are read. Archives may have been changed by others: nothing outside
// the archive is pointed to, nothing unpacks to more than its bound, and entries are in their order. Pure.
// Errors: kCorrupt, kUnsupportedFormat. Source: PMTiles specification version 3, chapters 3 (header; 3.3,
// tile numbers), 4 (directories) and 5 (metadata).
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geo/tile_id.h"

namespace skyquilt::storage {

// A gzip member that is always the same (no date, no name). `level`: zlib's, -1 its usual one.
std::string Gzip(std::string_view bytes, int level = -1);

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
// How much of an archive's beginning has header and root.
inline constexpr std::size_t kPmtilesHeadBytes = 16384;
inline constexpr std::size_t kPmtilesRootBytes = kPmtilesHeadBytes - kPmtilesHeaderBytes;

// Entries by rising tile number.
PmtilesDirectories MakePmtilesDirectories(const std::vector<PmtilesEntry>& entries);

struct PmtilesSection {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

// The numbers of a header that is there to its end, by their places.
class PmtilesFields {
 public:
  explicit PmtilesFields(std::string_view header) : header_(header) {}
  template <typename Number>
  Number At(std::size_t offset) const {
    Number number{};
    std::memcpy(&number, header_.data() + offset, sizeof(number));
    return number;
  }
  PmtilesSection SectionAt(std::size_t offset) const {
    return {At<std::uint64_t>(offset), At<std::uint64_t>(offset + 8)};
  }
  int ByteAt(std::size_t offset) const { return At<std::uint8_t>(offset); }
  double DegreesAt(std::size_t offset) const { return 1e-7 * At<std::int32_t>(offset); }

 private:
  std::string_view header_;
};

struct PmtilesHeader {
  PmtilesSection root, metadata, leaves, tiles;
  int min_zoom = 0, max_zoom = 0;
  double west_deg = 0, south_deg = 0, east_deg = 0, north_deg = 0;
  std::string format;  // of its tiles, as MBTiles has it: "jpg", "png" or "webp"
};

Result<PmtilesHeader> ParsePmtilesHeader(std::string_view archive);
// A directory as it lies in the archive, packed. Entries with a run of zero lead to leaves.
Result<std::vector<PmtilesEntry>> ParsePmtilesDirectory(std::string_view packed);
// As MBTiles names them: name, description, attribution, tile_size, bounds, minzoom, maxzoom, format.
Result<std::map<std::string, std::string>> ParsePmtilesMetadata(std::string_view packed,
                                                                const PmtilesHeader& header);
// The entry that has this tile, or the leaf in which it is; absent: none has.
std::optional<PmtilesEntry> FindPmtilesEntry(const std::vector<PmtilesEntry>& entries, std::uint64_t tile);

}  // namespace skyquilt::storage
