// Which part of each photo a map needs, so that no more of it is decoded and kept: the seam map says which
// ground a photo shows, the cameras where that is in it. Boxes of pixels of the full-size photo, which may
// reach beyond it. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/image/decoded_image.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/block_weights.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

// By photo; nothing for one that shows nothing. A little more than what is shown as a rule; at the
// map's edge, or where the ground is rough, it may be less.
std::vector<image::PixelBox> ShownRegions(const alignment::AlignedFlight& flight,
                                          const ground::GroundSurface& ground, const SeamMap& seams);

// All that one photo shows of a block, its transitions to others included; square_px: of BlockShares.
image::PixelBox ShownBy(const PhotoShare& share, int square_px, const PhotoView& view,
                        const BlockGeometry& geometry);

}  // namespace skyquilt::render
