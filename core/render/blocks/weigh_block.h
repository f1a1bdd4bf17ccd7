// WeighBlock: which photos show which pixels of a block, from the seam map and the photos' views, before any
// photo is decoded. What the picture and the layers beside it are made from, so that they agree; and which
// part of each photo that takes (ShownRegions, ShownBy), so that no more of it is decoded and kept. Pure; any
// thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/image/decoded_image.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/block_weights.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

// Marks in the photos' views of a block what something else stands before, where the ground has steps. What
// no photo sees at all is hidden from none, so that the map has no holes: the seams choose who shows it.
// views[i] belongs to photos[i], an index into the flight. `asked`: by node, whether it matters there. Gives,
// by node, where the pictures of some lie and something stands before all of them; empty: nowhere.
std::vector<bool> HideGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<std::uint32_t>& photos, const BlockGeometry& block,
                             const std::vector<std::uint8_t>& asked, std::vector<PhotoView>& views);

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

// What the map shows of each photo: the seam map says which ground it shows, the cameras where that is in it.
// Boxes of pixels of the full-size photo, which may reach beyond it; nothing for one that shows nothing. A
// little more than what is shown as a rule; at the map's edge, or where the ground is rough, it may be less.
std::vector<image::PixelBox> ShownRegions(const alignment::AlignedFlight& flight,
                                          const ground::GroundSurface& ground, const SeamMap& seams);

// All that one photo shows of a block, its transitions to others included; square_px: of BlockShares.
image::PixelBox ShownBy(const PhotoShare& share, int square_px, const PhotoView& view,
                        const BlockGeometry& geometry);

}  // namespace skyquilt::render
