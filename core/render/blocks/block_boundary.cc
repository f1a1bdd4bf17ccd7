#include "core/render/blocks/block_boundary.h"

#include <algorithm>

namespace skyquilt::render {

BlockBoundary::BlockBoundary(const MosaicPlan& plan, const geo::TileId& block_tile)
    : side_(static_cast<std::size_t>(plan.BlockSizePx())) {
  if (plan.boundary_on_blocks == nullptr) return;
  if (plan.boundary_on_blocks->Mask(block_tile, inside_) == geo::Cover::kAll) inside_.clear();
}

void BlockBoundary::Cut(image::RgbaImage& image) const {
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    if (inside_[i] == 0) std::fill_n(image.rgba.data() + 4 * i, 4, std::uint8_t{0});
  }
}

}  // namespace skyquilt::render
