// WeighBlock: which photos show which pixels of a block, from the seam map and the photos' views, before any
// photo is decoded. What the picture and the layers beside it are made from, so that they agree. Pure; any
// thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/block_weights.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

struct WeighedBlock {
  BlockCells cells;  // refers to the seam map
  BlockGeometry geometry;
  std::vector<std::uint32_t> photos;  // indices in the flight, rising
  std::vector<PhotoView> views;       // by photos
  BlockShares shares;
};

WeighedBlock WeighBlock(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                        const SeamMap& seams, const MosaicPlan& plan, const RenderBlock& block,
                        BlockGeometry geometry);

}  // namespace skyquilt::render
