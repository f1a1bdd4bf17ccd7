#include "core/render/blocks/weigh_block.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/render/blocks/hide_ground.h"

namespace skyquilt::render {

namespace {

// By node: whether it lies at a cell of which every pixel is asked who sees it. Nothing over smooth ground.
std::vector<bool> NodesAsked(const BlockCells& cells, const BlockGeometry& geometry,
                             const ground::GroundSurface& ground) {
  std::vector<bool> asked;
  if (!ground.HasSteps()) return asked;
  asked.resize(geometry.ground_in_enu.size());
  const int nodes = cells.seams.grid.cell_px / geometry.node_step_px;  // a cell has
  for (int row = 0; row < cells.side; ++row) {
    for (int column = 0; column < cells.side; ++column) {
      if (cells.IsWhole(column, row)) continue;
      for (int y = row * nodes; y <= (row + 1) * nodes; ++y) {
        const auto first =
            asked.begin() + static_cast<std::ptrdiff_t>(y) * geometry.nodes_per_side + column * nodes;
        std::fill(first, first + nodes + 1, true);
      }
    }
  }
  return asked;
}

}  // namespace

WeighedBlock WeighBlock(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                        const SeamMap& seams, const MosaicPlan& plan, const RenderBlock& block,
                        BlockGeometry geometry) {
  const BlockCells cells(seams, block.tile, plan.block_levels);
  WeighedBlock weighed{cells, std::move(geometry), cells.PhotosOf(block), {}, {}};
  weighed.views.reserve(weighed.photos.size());
  for (const std::uint32_t photo : weighed.photos) {
    weighed.views.push_back(ViewBlock(flight.photos[photo], weighed.geometry));
  }
  HideGround(flight, ground, weighed.photos, weighed.geometry, NodesAsked(cells, weighed.geometry, ground),
             weighed.views);
  weighed.shares =
      WeighPhotos(flight, weighed.photos, weighed.views, weighed.geometry, cells, plan.feather_m);
  return weighed;
}

}  // namespace skyquilt::render
