#include "server/surface/write_surface.h"

#include <algorithm>
#include <utility>

#include "core/base/scoped_timer.h"
#include "core/base/try.h"
#include "core/surface/match_surface.h"
#include "storage/exports/heights/surface_writer.h"

namespace skyquilt::server {
namespace {

constexpr double kCellPx = 2.0;  // ground pixels that a cell spans
// Below this share of measured cells the heights are mostly a guess, which is said.
constexpr double kMostlyMeasured = 0.5;

// Around the map's covered ground.
geo::Bounds2 AreaOf(const pipeline::BuiltMosaic& built) {
  const geo::LatLonBounds& bounds = built.report.bounds;
  geo::Bounds2 area;
  for (const double lat_deg : {bounds.south_deg, bounds.north_deg}) {
    for (const double lon_deg : {bounds.west_deg, bounds.east_deg}) {
      const Eigen::Vector3d corner =
          built.flight.frame.EnuAtHeight({lat_deg, lon_deg}, built.ground.MeanHeight());
      area.Include(Eigen::Vector2d(corner.head<2>()));
    }
  }
  return area;
}

}  // namespace

Result<void> WriteSurface(pipeline::BuiltMosaic& built, const pipeline::MosaicOptions& options,
                          const flight::PhotoSource& photos, const std::filesystem::path& out_dir,
                          Progress& progress) {
  progress.BeginStage("surface");
  pipeline::StageTiming timing{"surface", 0.0, 0.0};
  {
    ScopedTimer timer(timing.wall_s);
    ScopedCpuTimer cpu_timer(timing.cpu_s);
    surface::SurfaceOptions matching;
    matching.threads = options.threads;
    matching.photo_budget_bytes = std::min(matching.photo_budget_bytes, options.max_memory_bytes / 4);
    const double cell_m = kCellPx * built.report.gsd_m;
    const surface::SurfaceGrid grid = surface::GridOver(AreaOf(built), cell_m);
    storage::SurfaceWriter writer(out_dir, built.flight.frame, grid, built.ground.MeanHeight(),
                                  options.threads, progress);
    SKYQUILT_TRY(writer.Begin());
    SKYQUILT_TRY(surface::MatchSurfaceBlocks(
        built.flight, photos, built.ground, grid, matching,
        [&](surface::SurfaceBlock&& block) { return writer.Put(block); }, progress));
    SKYQUILT_TRY(writer.Publish());
    built.report.surface = surface::SurfaceReport{cell_m, writer.MeasuredShare()};
  }
  built.report.timings.push_back(timing);
  if (built.report.surface->measured_share < kMostlyMeasured) {
    built.report.warnings.push_back({flight::RemarkCode::kHeightsMostlyFilled,
                                     {{"measured_percent", 100.0 * built.report.surface->measured_share}}});
  }
  return {};
}

}  // namespace skyquilt::server
