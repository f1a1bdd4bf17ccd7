// RenderTiles: the whole pyramid, block by block straight into the sink. Never more in memory than the
// decoded-photo budget, a block per thread and one open parent per level. The same bytes in the same order
// with any number of threads. Blocking. Errors: those of decoding and of the sink; kCancelled.
#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/pyramid/encode_tile.h"
#include "core/pyramid/map_memory.h"
#include "core/pyramid/tile_sink.h"
#include "core/render/blocks/render_block.h"

namespace skyquilt::render {

struct RenderOptions {
  int threads = 0;
  pyramid::EncodeOptions encode;
};

// What an earlier run left of this map, and what photos' bytes it is to be compared by.
struct RenderMemory {
  pyramid::MapMemory& map;
  const std::vector<Digest>& photo_digests;  // of the files of flight.photos
};

struct RenderReport {
  std::int64_t tiles = 0;
  std::int64_t base_tiles = 0;
  double covered_m2 = 0.0;       // of ground, each block by its latitude
  geo::Bounds2 covered_in_merc;  // of the base tiles' covered pixels
  std::int64_t blocks_kept = 0;  // taken over from an earlier run, of all
  std::int64_t blocks = 0;
};

// `memory`: may be null. Blocks of which nothing has changed are taken from it; the tiles are the same as
// without.
Result<RenderReport> RenderTiles(const RenderContext& context, const RenderOptions& options,
                                 pyramid::TileSink& sink, Progress& progress,
                                 const RenderMemory* memory = nullptr);

}  // namespace skyquilt::render
