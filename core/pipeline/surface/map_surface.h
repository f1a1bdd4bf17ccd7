// MatchMapSurface: the heights of a flight's map, as its photos show them, for whatever stands them upright
// or hands them out: over all that the photos see, in cells of kSurfaceCellPx pixels of the map, coarser ones
// where those would not fit in a quarter of the memory. Frame enu, metres. Blocking; uses all the threads
// asked for; the same with any number. Errors: kCancelled, those of PlanMosaic.
#pragma once

#include <optional>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/render/mosaic_plan.h"
#include "core/surface/dense_surface.h"
#include "core/surface/surface_options.h"

namespace skyquilt::pipeline {

inline constexpr double kSurfaceCellPx = 2.0;

struct MapSurface {
  double cell_m = 1.0;
  double measured_share = 0.0;
  ground::GroundSurface ground;                  // the heights, and the smooth ground where no photo looks
  std::optional<surface::DenseSurface> heights;  // where they are written beside the map
};

// Around the part of enu that lies below geographic bounds, at that height.
geo::Bounds2 AreaBelow(const geo::LatLonBounds& bounds, const geo::LocalFrame& frame, double z_in_enu_m);

// What the map was asked to be laid on, and whether what stands on the ground is to be shown upright.
MapGround GroundAsked(const FlightFacts& facts);
bool StandsUpright(const FlightFacts& facts);

surface::SurfaceOptions SurfaceWithin(const MosaicOptions& options);

// Ground size of the map's pixels, or of the photos' where coarser. `gsd_m`: where somebody said it.
double FinestShownM(const render::MosaicPlan& plan, const std::optional<double>& gsd_m,
                    const alignment::AlignedFlight& flight);

// What the report says of heights, and the note where most of them are a guess.
void TellSurface(double cell_m, double measured_share, MosaicReport& report);

Result<MapSurface> MatchMapSurface(const FlightFacts& facts, const std::optional<double>& gsd_m,
                                   const MosaicOptions& options, const flight::PhotoSource& photos,
                                   Progress& progress);

}  // namespace skyquilt::pipeline
