// RenderBlock: one block of the map at base zoom, from whichever photos see it. Pure but for the
// decoded-photo cache; any number of threads at a time. Errors: those of decoding a photo.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/ground/ground_surface.h"
#include "core/image/rgba_image.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/photo_cache.h"
#include "core/render/exposure/exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

struct RenderContext {
  const alignment::AlignedFlight& flight;
  const ground::GroundSurface& ground;
  const ExposureModel& exposure;
  const SeamMap& seams;
  const MosaicPlan& plan;
  PhotoCache& cache;
};

// The block's pixels, plan.BlockSizePx() a side; transparent where no photo sees the ground and
// beyond the plan's boundary.
Result<image::RgbaImage> RenderBlockPixels(const RenderContext& context, const RenderBlock& block);
// The same, where the ground below the block is known already.
BlockGeometry GeometryOf(const RenderContext& context, const RenderBlock& block);
Result<image::RgbaImage> RenderBlockPixels(const RenderContext& context, const RenderBlock& block,
                                           BlockGeometry ground_below);

// Ground size of a pixel at the base zoom.
double OutputPixelM(const MosaicPlan& plan, const alignment::AlignedFlight& flight);

// The scale at which a photo is decoded for an output pixel of this size: full size near or above its own
// resolution, 1/2, 1/4, 1/8 below, so that resampling never skips pixels.
int DenominatorFor(const alignment::AlignedPhoto& photo, double output_pixel_m);

}  // namespace skyquilt::render
