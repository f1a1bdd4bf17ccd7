// ModelGround: the surface the map is draped over, from the tie points of an aligned flight: a level plane,
// a smooth grid of heights where the points show that the ground is not one, or an elevation model moved to
// fit the points. Chosen by evidence: points held back must lie clearly nearer to the grid or the model than
// to the plane. Never fails: without points it is the elevation model as placed by take-off, or else the flat
// ground of the recorded poses. Pure but for the model's reads; any thread. Method: outliers against the
// median of their neighbourhood dropped, medians per cell, membrane least squares pulled weakly to the mean
// plane, or to the elevation model shifted by the median, so that nothing bulges or curls where no points
// are.
#pragma once

#include <optional>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/dem_source.h"
#include "core/ground/ground_surface.h"
#include "core/ground/model_ground_report.h"

namespace skyquilt::ground {

struct ElevationModel {
  const geo::DemSource* source = nullptr;
  double zero_m = 0.0;  // its height at z = 0 of the flight's frame
};

GroundSurface ModelGround(const alignment::AlignedFlight& flight, ModelGroundReport& report,
                          const std::optional<ElevationModel>& elevation_model = std::nullopt);

}  // namespace skyquilt::ground
