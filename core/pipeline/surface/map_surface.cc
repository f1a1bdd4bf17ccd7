#include "core/pipeline/surface/map_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/bilinear_grid.h"
#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/pipeline/memory_budget.h"
#include "core/pipeline/surface/choose_ground.h"
#include "core/pipeline/surface/trust_heights.h"
#include "core/render/blocks/render_block.h"
#include "core/render/plan_mosaic.h"
#include "core/surface/match_surface.h"
#include "core/surface/views/surface_camera.h"

namespace skyquilt::pipeline {
namespace {

// Below this share of measured cells the heights are mostly a guess, which is said.
constexpr double kMostlyMeasured = 0.5;
// Heights, twice where they are written too, confidence and photos that agree.
constexpr std::int64_t kBytesPerCell = 10;

// Of the cells that a photo shows, the share whose height was measured; 0 where there are none.
double MeasuredShare(const surface::CellHeights& cells) {
  std::size_t shown = 0, measured = 0;
  for (std::size_t i = 0; i < cells.heights_m.size(); ++i) {
    shown += std::isnan(cells.heights_m[i]) ? 0 : 1;
    measured += cells.agreeing_photos[i] != 0 ? 1 : 0;
  }
  return shown == 0 ? 0.0 : static_cast<double>(measured) / static_cast<double>(shown);
}

// By square: how many photos see its middle, on the smooth ground; no more are counted than are enough.
std::vector<std::uint8_t> PhotosBySquare(const FlightFacts& facts, const surface::SurfaceGrid& grid,
                                         int columns, int rows) {
  std::vector<std::uint8_t> photos(static_cast<std::size_t>(columns) * rows, 0);
  const double square_m = kTrustSquareCells * grid.cell_m;
  const Eigen::Vector2d first =
      grid.south_west_in_enu + Eigen::Vector2d::Constant(0.5 * (kTrustSquareCells - 1) * grid.cell_m);
  for (const surface::SurfaceCamera& camera : surface::SurfaceCameras(facts.flight, facts.ground, 0.0, 0.0)) {
    const Eigen::Vector2d low = (camera.seen_in_enu.min - first) / square_m,
                          high = (camera.seen_in_enu.max - first) / square_m;
    const int left = std::max(0, static_cast<int>(std::floor(low.x()))),
              bottom = std::max(0, static_cast<int>(std::floor(low.y())));
    for (int row = bottom; row < rows && row <= high.y() + 1.0; ++row) {
      for (int column = left; column < columns && column <= high.x() + 1.0; ++column) {
        const Eigen::Vector2d at = first + square_m * Eigen::Vector2d(column, row);
        std::uint8_t& count = photos[static_cast<std::size_t>(row) * columns + column];
        if (count < kPhotosThatBearOut && camera.Sees({at.x(), at.y(), facts.ground.HeightAt(at)})) ++count;
      }
    }
  }
  return photos;
}

// Where no photo looks, and where too few do, lies the smooth ground.
ground::GroundSurface GroundOf(const surface::SurfaceGrid& grid, std::vector<float> heights_m,
                               const std::vector<std::uint8_t>& agreeing_photos, const FlightFacts& facts,
                               int threads) {
  const ground::GroundSurface& smooth = facts.ground;
  const int squares_across = grid.columns / kTrustSquareCells + 2,
            squares_up = grid.rows / kTrustSquareCells + 2;
  const std::vector<float> trust = TrustHeights(
      PhotosBySquare(facts, grid, squares_across, squares_up),
      MeasuredAround(grid, agreeing_photos, squares_across, squares_up), squares_across, squares_up);
  ParallelFor(static_cast<std::size_t>(grid.rows), threads, [&](std::size_t row) {
    float* const of_row = heights_m.data() + row * static_cast<std::size_t>(grid.columns);
    const auto y = static_cast<double>(row);
    for (int column = 0; column < grid.columns; ++column) {
      float& height_m = of_row[column];
      const bool is_known = !std::isnan(height_m);
      const double share =
          is_known ? BilinearAt(trust, squares_across, squares_up, (column + 0.5) / kTrustSquareCells - 0.5,
                                (y + 0.5) / kTrustSquareCells - 0.5)
                   : 0.0;
      if (share >= 1.0) continue;
      const double ground_m =
          smooth.HeightAt(grid.south_west_in_enu + grid.cell_m * Eigen::Vector2d(column, y));
      height_m = static_cast<float>(is_known ? ground_m + share * (height_m - ground_m) : ground_m);
    }
  });
  return ground::GroundSurface::WithSteps(grid.south_west_in_enu, grid.cell_m, grid.columns, grid.rows,
                                          std::move(heights_m), smooth.MeanHeight());
}

}  // namespace

geo::Bounds2 AreaBelow(const geo::LatLonBounds& bounds, const geo::LocalFrame& frame, double z_in_enu_m) {
  geo::Bounds2 area;
  for (const double lat_deg : {bounds.south_deg, bounds.north_deg}) {
    for (const double lon_deg : {bounds.west_deg, bounds.east_deg})
      area.Include(Eigen::Vector2d(frame.EnuAtHeight({lat_deg, lon_deg}, z_in_enu_m).head<2>()));
  }
  return area;
}

MapGround GroundAsked(const FlightFacts& facts) {
  const auto asked = facts.asked.find("--surface");
  for (const auto& [name, ground] : kMapGrounds) {
    if (asked != facts.asked.end() && asked->second == name) return ground;
  }
  return MapGround::kSmooth;
}

bool StandsUpright(const FlightFacts& facts) {
  const MapGround asked = GroundAsked(facts);
  return asked == MapGround::kDense ||
         (asked == MapGround::kAuto && facts.ground_choice && IsUpright(*facts.ground_choice));
}

void TellSurface(double cell_m, double measured_share, MosaicReport& report) {
  report.surface = SurfaceReport{cell_m, measured_share};
  if (measured_share >= kMostlyMeasured) return;
  report.warnings.push_back(
      {flight::RemarkCode::kHeightsMostlyFilled, {{"measured_percent", 100.0 * measured_share}}});
}

surface::SurfaceOptions SurfaceWithin(const MosaicOptions& options) {
  surface::SurfaceOptions matching;
  matching.threads = options.threads;
  matching.photo_budget_bytes = std::min(matching.photo_budget_bytes, options.max_memory_bytes / 4);
  return matching;
}

double FinestShownM(const render::MosaicPlan& plan, const std::optional<double>& gsd_m,
                    const alignment::AlignedFlight& flight) {
  return std::max({plan.gsd_m, gsd_m.value_or(0.0), render::OutputPixelM(plan, flight)});
}

Result<MapSurface> MatchMapSurface(const FlightFacts& facts, const std::optional<double>& gsd_m,
                                   const MosaicOptions& options, const flight::PhotoSource& photos,
                                   Progress& progress) {
  render::PlanOptions plan_options = PlanWithin(options);
  plan_options.gsd_m = gsd_m;
  SKYQUILT_TRY_ASSIGN(const render::MosaicPlan plan,
                      render::PlanMosaic(facts.flight, facts.ground, plan_options));
  const geo::Bounds2 area = AreaBelow(geo::LatLonBoundsFromMerc(plan.bounds_in_merc), facts.flight.frame,
                                      facts.ground.MeanHeight());
  const auto whole_cells = options.max_memory_bytes / 4 / kBytesPerCell;
  const auto most_cells = static_cast<double>(whole_cells);
  const double cell_m = std::max(kSurfaceCellPx * FinestShownM(plan, gsd_m, facts.flight),
                                 std::sqrt(area.Width() * area.Height() / most_cells));
  SKYQUILT_TRY_ASSIGN(surface::DenseSurface heights, surface::MatchSurface(facts.flight, photos, facts.ground,
                                                                           surface::GridOver(area, cell_m),
                                                                           SurfaceWithin(options), progress));
  const double measured_share = MeasuredShare(heights.cells);
  const bool are_written = options.heights != MapHeights::kNone;
  std::vector<float> laid_m = are_written ? heights.cells.heights_m : std::move(heights.cells.heights_m);
  ground::GroundSurface ground =
      GroundOf(heights.grid, std::move(laid_m), heights.cells.agreeing_photos, facts, options.threads);
  return MapSurface{cell_m, measured_share, std::move(ground),
                    are_written ? std::optional(std::move(heights)) : std::nullopt};
}

}  // namespace skyquilt::pipeline
