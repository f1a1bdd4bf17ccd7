// MatchBlock: the heights of one block of cells, from levels of cells 8, 4, 2 and 1 times as large: the
// coarsest looks through the whole range about the smooth ground, each finer one about what the one before
// found. What it gives depends on the block alone. Any number of threads at a time, each with a block of its
// own. Cannot fail: what cannot be measured is filled.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/surface/dense_surface.h"
#include "core/surface/paths/semi_global.h"
#include "core/surface/surface_options.h"
#include "core/surface/views/gray_photos.h"
#include "core/surface/views/surface_camera.h"

namespace skyquilt::surface {

inline constexpr int kSurfaceLevels = 4;

struct MatchContext {
  const alignment::AlignedFlight& flight;
  const std::vector<SurfaceCamera>& cameras;
  const ground::GroundSurface& ground;
  const SurfaceGrid& grid;
  const SurfaceOptions& options;
  double below_m = 0.0, above_m = 0.0;  // the range about the ground
  GrayPhotos& photos;
};

// What is large of a block's work, taken again for the next one: a new page costs more than what is done in
// it.
struct BlockMemory {
  SheetCosts costs;
  SheetSums sums;
  std::vector<std::uint8_t> gray;
};

// `memory` serves one block at a time.
SurfaceBlock MatchBlock(const MatchContext& context, const CellBox& box, BlockMemory& memory);

}  // namespace skyquilt::surface
