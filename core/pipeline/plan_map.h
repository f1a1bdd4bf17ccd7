// PlanMap: what is decided of a map before the first of its pixels is rendered: the tiles, the light and
// which photo shows what. From the facts of a placed flight alone, so that every process that has these
// decides the same. Blocking; the result does not depend on threads. Errors: those of PlanMosaic and of
// MosaicOptions::CheckGsd.
#pragma once

#include <optional>

#include "core/base/result.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/stage_runner.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/render/exposure/exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::pipeline {

struct PlannedMap {
  std::optional<double> gsd_m;  // of a pixel of the map, where somebody said so
  render::MosaicPlan plan;
  render::ExposureModel exposure;
  render::SeamMap seams;
  bool stands_upright = false;
  bool is_gsd_asked = false;  // by this run's options, or by those of the map that it goes on from

  // What the facts remember of it.
  MapAppearance Appearance() const;
};

// `gsd_m`: where the options do not say it. Photos that facts.appearance knows keep their light and their
// place. `range`: of the plan's blocks, all that are wanted; then the plan has no others, and
// facts.appearance must be there. kInvalidArgument: the map does not have so many blocks. `upright`: heights
// with all that stands on the ground, for the seams to go round; null: the smooth ground.
Result<PlannedMap> PlanMap(const FlightFacts& facts, const std::optional<double>& gsd_m,
                           const MosaicOptions& options, StageRunner& stages,
                           const std::optional<UnitRange>& range = {},
                           const ground::GroundSurface* upright = nullptr);

}  // namespace skyquilt::pipeline
