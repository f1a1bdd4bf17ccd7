// MatchSurface: a height for every cell of a grid, by comparing what aligned photos show of it at many
// heights over the smooth ground (object-space semi-global matching): coarse to fine, block by block, each
// with as much around it as its heights depend on. Memory is that of the photos in hand and of one block a
// thread; the values do not depend on the number of threads. Frame enu, metres. Photos whose poses are not
// aligned, or that cannot be decoded, take no part. Cells that no two photos show alike are filled and say
// so. Errors: kCancelled; kInvalidArgument for a grid without cells. Sources: Hirschmueller (2008); Bethmann
// and Luhmann, "Object-based multi-image semi-global matching" (2015); Kang, Szeliski and Chai (2001) for
// what is hidden.
#pragma once

#include <functional>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/ground/ground_surface.h"
#include "core/surface/dense_surface.h"
#include "core/surface/surface_options.h"

namespace skyquilt::surface {

// Around all of an area (at least one cell), its cells' centres at whole multiples of cell_m from enu's
// origin, so that maps of one flight have the same cells.
SurfaceGrid GridOver(const geo::Bounds2& area_in_enu, double cell_m);

// How far below and above the smooth ground heights are looked for: as the options allow, and as far as tie
// points lie off it.
struct HeightRange {
  double below_m = 0.0, above_m = 0.0;
};
HeightRange RangeAbout(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       const SurfaceOptions& options);

// Blocks are handed to `take` one at a time, always in the same order (along a Hilbert curve, so that photos
// are decoded about once). An error of `take` ends the work and is returned.
using TakeSurfaceBlock = std::function<Result<void>(SurfaceBlock&&)>;
Result<void> MatchSurfaceBlocks(const alignment::AlignedFlight& flight, const flight::PhotoSource& source,
                                const ground::GroundSurface& ground, const SurfaceGrid& grid,
                                const SurfaceOptions& options, const TakeSurfaceBlock& take,
                                Progress& progress);

Result<DenseSurface> MatchSurface(const alignment::AlignedFlight& flight, const flight::PhotoSource& source,
                                  const ground::GroundSurface& ground, const SurfaceGrid& grid,
                                  const SurfaceOptions& options, Progress& progress);

}  // namespace skyquilt::surface
