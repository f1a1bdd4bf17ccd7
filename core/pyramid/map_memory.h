// MapMemory: the port through which a map remembers what it was made from. Implemented by
// storage (MapKeeper).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/digest.h"
#include "core/base/result.h"
#include "core/geo/bounds.h"
#include "core/geo/tile_id.h"

namespace skyquilt::pyramid {

// What is known of a finished block of the map without its pixels.
struct KeptBlock {
  int levels = 0;          // zooms from the block as one tile down to the base tiles
  std::int64_t tiles = 0;  // base tiles and the block's own overviews
  std::int64_t base_tiles = 0;
  std::int64_t covered_pixels = 0;
  geo::Bounds2 covered_in_merc;
  std::vector<std::uint8_t> topmost;  // the block as one tile, as it was put; empty: no tile
};

// What an earlier run left: finished blocks and facts of the flight, so that a job that was killed goes on
// and a flight that grew is not rendered whole. DigestOf: any thread; the others: one thread at a time.
class MapMemory {
 public:
  virtual ~MapMemory() = default;
  // Of the inputs from which the earlier run made this block.
  virtual std::optional<Digest> DigestOf(const geo::TileId& block) const = 0;
  // Puts the earlier run's tiles of the block into this run's map and keeps them for the next, by the digest
  // of this run's inputs. `fringe_quality`: PNG tiles become what EncodeFringe makes of them.
  virtual Result<KeptBlock> Reuse(const geo::TileId& block, const Digest& digest,
                                  std::optional<int> fringe_quality) = 0;
  // All tiles of the block have been put.
  virtual Result<void> Keep(const geo::TileId& block, const Digest& digest, const KeptBlock& kept) = 0;
  // Facts that the earlier run remembered; empty: none.
  virtual const std::string& Recall() const = 0;
  virtual Result<void> Remember(std::string_view facts) = 0;
};

}  // namespace skyquilt::pyramid
