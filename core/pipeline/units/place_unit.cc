#include "core/pipeline/units/place_unit.h"

#include <utility>

#include "core/base/try.h"
#include "core/pipeline/place_flight.h"
#include "core/pipeline/plan_map.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/stage_runner.h"

namespace skyquilt::pipeline {

Result<PlacedUnit> PlaceFound(const std::vector<flight::InputFile>& files, FoundFiles found,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              const geo::DemSource* dem, Progress& progress) {
  SKYQUILT_TRY(options.Validate());
  MosaicReport report;
  StageRunner stages(report, progress);
  SKYQUILT_TRY_ASSIGN(auto placed,
                      PlaceFlight(files, options, source, dem, nullptr, stages, progress, std::move(found)));
  SKYQUILT_TRY_ASSIGN(const PlannedMap planned, PlanMap(placed.facts, placed.gsd_m, options, stages));
  placed.facts.appearance = planned.Appearance();
  return PlacedUnit{WriteFacts(placed.facts), FindShown(placed.facts, planned), planned.plan.blocks.size(),
                    std::move(report.timings)};
}

}  // namespace skyquilt::pipeline
