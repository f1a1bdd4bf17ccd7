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
#include <string>

#include "core/alignment/aligned_flight.h"
#include "core/ground/dem_grid.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::ground {

struct ModelGroundReport {
  std::string model;   // "plane", "grid" or "elevation model"
  std::string reason;  // why, in words
  int points_given = 0;
  int points_used = 0;
  double plane_error_m = 0.0;  // median height error of points held back, against the plane
  double grid_error_m = 0.0;   // and against the grid; 0 where none was tried
  std::optional<double>
      dem_error_m;  // and against the elevation model, moved up as a whole; nothing without one
  std::optional<double> dem_shift_m;  // how far up it was moved; nothing where it was not taken
  double cell_m = 0.0;
  double lowest_m = 0.0, highest_m = 0.0, mean_m = 0.0;  // in enu
  double seconds = 0.0;
};

GroundSurface ModelGround(const alignment::AlignedFlight& flight, ModelGroundReport& report,
                          const std::optional<ElevationModel>& elevation_model = std::nullopt);

std::string ModelGroundReportJson(const ModelGroundReport& report);

}  // namespace skyquilt::ground
