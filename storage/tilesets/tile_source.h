// TileSource: where the tiles of one tileset are read from, be it a finished map, a layer beside it or a
// preview that grows. Any number of threads. Errors: those of the tileset.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"

namespace skyquilt::storage {

// More than any tile has: those of 1024 pixels are below two megabytes.
inline constexpr std::uint64_t kMaxTileBytes = std::uint64_t{32} << 20;

struct FoundTile {
  std::uint64_t content_id = 0;      // equal ids mean equal bytes; stable for a file, so fit for an ETag
  std::optional<std::string> bytes;  // there already when finding it meant reading it
};

class TileSource {
 public:
  virtual ~TileSource() = default;
  // Absent: it has no such tile.
  virtual Result<std::optional<FoundTile>> Find(const geo::TileId& tile) = 0;
  // True: Find reads no more than a page or two of a file that is open.
  virtual bool IsAtHand(const geo::TileId&) const { return true; }
  // The bytes of a tile that Find answered; as it stands here, of one that finds none without them.
  virtual Result<std::string> Load(FoundTile tile);
};

// As MBTiles names them. Beside its names: `tile_size`, and `fringe`, "webp" where partly transparent tiles
// are WebP and opaque ones are JPEG or PNG. `format` is that of the first tile then, which lies at the edge.
using TilesetFacts = std::map<std::string, std::string>;

// A finished map, or a layer of one: immutable, and it says what it is.
class MapTiles : public TileSource {
 public:
  virtual const TilesetFacts& metadata() const = 0;
};

// What a tileset says of its tiles, where each may still be of any format.
image::TileEncoding EncodingOf(const TilesetFacts& metadata);
// "name", "format"; empty where it says nothing.
std::string TilesetText(const TilesetFacts& metadata, const char* key);
// "minzoom", "tile_size"; `fallback` where it says no number.
int TilesetNumber(const TilesetFacts& metadata, const char* key, int fallback);
std::optional<geo::LatLonBounds> TilesetBounds(const TilesetFacts& metadata);

}  // namespace skyquilt::storage
