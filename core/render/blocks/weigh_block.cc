#include "core/render/blocks/weigh_block.h"

#include <utility>

namespace skyquilt::render {

WeighedBlock WeighBlock(const alignment::AlignedFlight& flight, const SeamMap& seams, const MosaicPlan& plan,
                        const RenderBlock& block, BlockGeometry geometry) {
  const BlockCells cells(seams, block.tile, plan.block_levels);
  WeighedBlock weighed{cells, std::move(geometry), cells.PhotosOf(block), {}, {}};
  weighed.views.reserve(weighed.photos.size());
  for (const std::uint32_t photo : weighed.photos) {
    weighed.views.push_back(ViewBlock(flight.photos[photo], weighed.geometry));
  }
  weighed.shares =
      WeighPhotos(flight, weighed.photos, weighed.views, weighed.geometry, cells, plan.feather_m);
  return weighed;
}

}  // namespace skyquilt::render
