#include "core/pipeline/plan_map.h"

#include <algorithm>

#include "core/base/try.h"
#include "core/pipeline/memory_budget.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {

MapAppearance PlannedMap::Appearance() const {
  return {gsd_m.value_or(plan.gsd_m),
          {exposure.light, exposure.photos},
          seams.grid,
          seams.labels,
          stands_upright,
          is_gsd_asked};
}

Result<PlannedMap> PlanMap(const FlightFacts& facts, const std::optional<double>& gsd_m,
                           const MosaicOptions& options, StageRunner& stages,
                           const std::optional<UnitRange>& range, const ground::GroundSurface* upright) {
  const alignment::AlignedFlight& aligned = facts.flight;
  const ground::GroundSurface& ground = facts.ground;
  PlannedMap map;
  map.stands_upright = upright != nullptr;
  map.is_gsd_asked = options.gsd_m || (facts.appearance && facts.appearance->is_gsd_asked);
  map.gsd_m = options.gsd_m ? options.gsd_m : gsd_m;
  if (!map.gsd_m && facts.appearance) map.gsd_m = facts.appearance->gsd_m;
  render::PlanOptions plan_options = PlanWithin(options);
  plan_options.gsd_m = map.gsd_m;
  plan_options.boundary = facts.boundary ? &*facts.boundary : nullptr;
  SKYQUILT_TRY_ASSIGN(map.plan,
                      stages.Run("plan", [&] { return render::PlanMosaic(aligned, ground, plan_options); }));
  SKYQUILT_TRY(options.CheckGsd(map.plan.gsd_m));
  if (options.not_finer_than_photos && map.gsd_m) map.gsd_m = std::max(*map.gsd_m, map.plan.gsd_m);

  if (range) {
    std::vector<render::RenderBlock>& blocks = map.plan.blocks;
    if (range->first > range->end || range->end > blocks.size())
      return Error{ErrorCode::kInvalidArgument, "The map does not have so many blocks.", ""};
    blocks = {blocks.begin() + static_cast<std::ptrdiff_t>(range->first),
              blocks.begin() + static_cast<std::ptrdiff_t>(range->end)};
  }
  map.exposure = stages.Run("expose", [&] {
    if (facts.appearance)
      return render::ExtendExposure(aligned, ground, facts.thumbnails, facts.appearance->exposure);
    return render::EstimateExposure(aligned, ground, facts.thumbnails);
  });
  map.seams = stages.Run("seam", [&] {
    render::SeamOptions seam_options;
    seam_options.threads = options.threads;
    std::optional<render::KnownLabels> known;
    if (facts.appearance && facts.appearance->stands_upright == map.stands_upright)
      known = {facts.appearance->grid, facts.appearance->labels, facts.appearance->exposure.photos.size()};
    if (known) seam_options.known = &*known;
    if (range) seam_options.only_blocks = &map.plan.blocks;
    return render::BuildSeamMap(aligned, upright != nullptr ? *upright : ground, map.plan, map.exposure,
                                facts.thumbnails, seam_options);
  });
  return map;
}

}  // namespace skyquilt::pipeline
