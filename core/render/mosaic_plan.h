// MosaicPlan: what will be rendered, in which order. Value of plan_mosaic, input of render_tiles. Any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/geo/boundary.h"
#include "core/geo/bounds.h"
#include "core/geo/tile_id.h"

namespace skyquilt::render {

// A square of base tiles rendered in one go: the part of the base zoom below one coarser tile.
struct RenderBlock {
  geo::TileId tile;                   // of zoom base_zoom - block_levels
  std::vector<std::uint32_t> photos;  // indices of the photos that see it, rising
};

// What a photo's view of one cell of the seam grid takes: colours, scores, what evens the light, marks.
inline constexpr std::int64_t kSeamCellBytes = 16;

struct MosaicPlan {
  double gsd_m = 0.0;  // ground size of a photo pixel at the image centres, median over the pixels
  int base_zoom = 0;
  int min_zoom = 0;      // where one tile holds the whole mosaic
  int block_levels = 2;  // a block is 2^block_levels tiles a side
  int tile_size_px = 256;
  geo::Bounds2 bounds_in_merc;
  std::vector<geo::Bounds2> seen_in_merc;  // by photo: what it may see; empty when it sees no ground
  std::vector<RenderBlock> blocks;         // along the Hilbert curve, so that neighbours share decoded photos
  std::int64_t output_pixels = 0;          // upper bound
  // On the pixels of whole blocks; null: nothing is cut. Blocks wholly beyond it are not among those above.
  std::shared_ptr<const geo::BoundaryOnZoom> boundary_on_blocks;
  std::int64_t max_seam_cells = std::int64_t{1} << 26;  // over all photos: at most kSeamCellBytes each

  int BlockSizePx() const { return tile_size_px << block_levels; }
};

}  // namespace skyquilt::render
