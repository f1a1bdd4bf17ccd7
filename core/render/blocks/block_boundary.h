// BlockBoundary: which pixels of a block lie within the boundary that the map is cut to. A pixel does where
// its middle does. A value; any thread. Memory: a byte a pixel of blocks that the boundary crosses, else
// nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geo/tile_id.h"
#include "core/image/rgba_image.h"
#include "core/render/mosaic_plan.h"

namespace skyquilt::render {

class BlockBoundary {
 public:
  BlockBoundary(const MosaicPlan& plan, const geo::TileId& block_tile);

  bool CutsNothing() const { return inside_.empty(); }
  bool Holds(int x, int y) const {
    return inside_.empty() || inside_[static_cast<std::size_t>(y) * side_ + static_cast<std::size_t>(x)] != 0;
  }
  // 1 within, 0 beyond, row by row; empty where nothing is cut.
  const std::vector<std::uint8_t>& inside() const { return inside_; }
  // Transparent black beyond.
  void Cut(image::RgbaImage& image) const;

 private:
  std::size_t side_;
  std::vector<std::uint8_t> inside_;
};

}  // namespace skyquilt::render
