// PlanMosaic: from aligned photos and the ground to zoom levels, tile blocks and their photos. Cheap (geometry
// only). Errors: kUnprocessable when no photo sees the ground, kTooLarge when the output would be absurd.
#pragma once

#include <optional>

#include "core/alignment/aligned_flight.h"
#include "core/base/result.h"
#include "core/ground/ground_surface.h"
#include "core/render/mosaic_plan.h"

namespace skyquilt::render {

struct PlanOptions {
  std::optional<double> gsd_m;  // of the output; default: that of the photos
  double feather_m = 0.0;       // 0 = 16 pixels
};

Result<MosaicPlan> PlanMosaic(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                              const PlanOptions& options);

}  // namespace skyquilt::render
