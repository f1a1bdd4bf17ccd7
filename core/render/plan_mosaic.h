// PlanMosaic: from aligned photos and the ground to zoom levels, tile blocks and their photos. Cheap
// (geometry only). Errors: kUnprocessable when no photo sees the ground or the boundary lies elsewhere,
// kTooLarge when the output would be absurd, and kInvalidArgument where the pixels asked for are far finer
// than the photos'. Its memory grows with the blocks, of which there are at most a million.
#pragma once

#include <optional>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/result.h"
#include "core/geo/boundary.h"
#include "core/ground/ground_surface.h"
#include "core/render/mosaic_plan.h"

namespace skyquilt::render {

struct PlanOptions {
  std::optional<double> gsd_m;  // of the output; default: that of the photos
  // What one block may take while it is rendered: tiles do not grow beyond (nor beyond what their decoders
  // take), and the pixels stay coarser.
  std::int64_t max_block_bytes = std::int64_t{600} << 20;
  std::int64_t max_seam_bytes = std::int64_t{1} << 30;  // of all photos' views of the seam grid
  bool not_finer_than_photos = false;                   // where gsd_m is: then it is not refused either
  const geo::Boundary* boundary = nullptr;              // that the map is cut to; photos lie as without
};

// What a block of this side takes while one thread renders it, and as half its size until its turn comes.
std::int64_t BlockBytes(int block_px);
// What the unfinished tiles of the overviews take beside the blocks.
std::int64_t OverviewBytes(const MosaicPlan& plan);

// In words for the user; `flight`: where it is.
Error BoundaryElsewhere(const geo::Boundary& boundary, const geo::LatLon& flight);

Result<MosaicPlan> PlanMosaic(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                              const PlanOptions& options);

}  // namespace skyquilt::render
