// Which photo shows which pixel of a block, and how neighbours blend across the seam: the seam map's cells,
// smoothed to pixels. Every weight is a function of the pixel's place alone, so it is the same in whatever
// block or thread it is computed. Where no photo of the seam map sees a pixel, the one that sees it best
// does. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

// A small square of the block in which a photo shows something.
struct SquareShare {
  static constexpr std::int32_t kAlone = -1;

  int x = 0, y = 0;                    // pixels of the block
  std::int32_t first_weight = kAlone;  // in PhotoShare::weights, row by row; kAlone: 1 everywhere
};

struct PhotoShare {
  std::uint32_t photo = 0;  // index in the flight
  std::vector<SquareShare> squares;
  std::vector<float> weights;  // those of all photos at a covered pixel add up to 1

  // Of a pixel of the block that one of its squares has.
  float WeightAt(const SquareShare& square, int x, int y, int square_px) const {
    if (square.first_weight == SquareShare::kAlone) return 1.0F;
    return weights[static_cast<std::size_t>(square.first_weight + (y - square.y) * square_px + x - square.x)];
  }
};

struct BlockShares {
  // A square lies in one quarter of a cell of the seam map and, over smooth ground, in one cell of nodes.
  int square_px = 0;
  std::vector<PhotoShare> photos;  // rising
};

// The part of the seam map below a block.
struct BlockCells {
  const SeamMap& seams;
  Eigen::Vector2i corner;  // the block's first cell
  int side = 0;            // cells

  BlockCells(const SeamMap& map, const geo::TileId& block_tile, int block_levels);
  // The photos that may show some of the block, rising: those of its cells and of the cells around that blend
  // into it; at the map's edge, where a pixel may be seen by a photo that has no cell here, all that see it.
  std::vector<std::uint32_t> PhotosOf(const RenderBlock& block) const {
    return IsInner() ? seams.PhotosIn(corner.x() - 1, corner.y() - 1, side + 2, side + 2) : block.photos;
  }
  // Whether all of it is shown by the cells' photos: no map edge, no photo edge within.
  bool IsInner() const;
  // So for one of its cells, which is then not asked pixel by pixel who sees it.
  bool IsWhole(int column, int row) const;
  // The photos of a cell and of those around, each once.
  std::vector<std::uint32_t> PhotosAround(int column, int row) const;
};

// views[i] belongs to photos[i]; photos are indices into the flight, rising.
BlockShares WeighPhotos(const alignment::AlignedFlight& flight, const std::vector<std::uint32_t>& photos,
                        const std::vector<PhotoView>& views, const BlockGeometry& block,
                        const BlockCells& cells);

}  // namespace skyquilt::render
