#include "server/surface/write_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <system_error>

#include "core/base/scoped_timer.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/surface/match_surface.h"
#include "core/surface/terrain/ground_sketch.h"
#include "storage/exports/heights/contours.h"
#include "storage/exports/heights/hillshade.h"
#include "storage/exports/heights/surface_writer.h"

namespace skyquilt::server {
namespace {

// Hands out what was matched for the map itself, a band of rows at a time: `grid` has its cells.
Result<void> PutMatched(const surface::DenseSurface& matched, const surface::SurfaceGrid& grid,
                        storage::SurfaceWriter& writer) {
  constexpr int kRowsAtOnce = 256;
  const Eigen::Vector2d shift =
      (grid.south_west_in_enu - matched.grid.south_west_in_enu) / matched.grid.cell_m;
  const int left = static_cast<int>(std::lround(shift.x())), low = static_cast<int>(std::lround(shift.y()));
  for (int row = 0; row < grid.rows; row += kRowsAtOnce) {
    surface::SurfaceBlock block;
    block.box = {0, row, grid.columns, std::min(kRowsAtOnce, grid.rows - row)};
    block.cells.heights_m.assign(block.box.Count(), std::numeric_limits<float>::quiet_NaN());
    block.cells.confidence.assign(block.box.Count(), 0);
    block.cells.agreeing_photos.assign(block.box.Count(), 0);
    for (int y = 0; y < block.box.rows; ++y) {
      for (int x = 0; x < block.box.columns; ++x) {
        const int column = left + x, from_row = low + row + y;
        if (column < 0 || from_row < 0 || column >= matched.grid.columns || from_row >= matched.grid.rows)
          continue;
        const std::size_t from = static_cast<std::size_t>(from_row) * matched.grid.columns + column,
                          to = static_cast<std::size_t>(y) * block.box.columns + x;
        block.cells.heights_m[to] = matched.cells.heights_m[from];
        block.cells.confidence[to] = matched.cells.confidence[from];
        block.cells.agreeing_photos[to] = matched.cells.agreeing_photos[from];
      }
    }
    SKYQUILT_TRY(writer.Put(block));
  }
  return {};
}

// Of an earlier map: they would pass for this one's.
void ForgetHeights(const std::filesystem::path& out_dir) {
  std::error_code gone;  // what cannot be removed stays, as what cannot be written would
  for (const char* name : {"dsm.tif", "dsm_photos.tif", "dsm_hillshade.tif", "dtm.tif", "dtm_ground.tif",
                           "contours.gpkg", "contours.geojson", "contours.dxf"})
    std::filesystem::remove(out_dir / name, gone);
}

}  // namespace

Result<void> WriteSurface(pipeline::BuiltMosaic& built, const pipeline::MosaicOptions& options,
                          const flight::PhotoSource& photos, const std::filesystem::path& out_dir,
                          Progress& progress) {
  const bool is_ground_wanted = options.heights == pipeline::MapHeights::kGround;
  progress.BeginStage("surface");
  pipeline::StageTiming timing{"surface", 0.0, 0.0};
  {
    ScopedTimer timer(timing.wall_s);
    ScopedCpuTimer cpu_timer(timing.cpu_s);
    const surface::DenseSurface* matched =
        built.surface && built.surface->heights ? &*built.surface->heights : nullptr;
    const double cell_m =
        matched != nullptr ? matched->grid.cell_m : pipeline::kSurfaceCellPx * built.report.gsd_m;
    const surface::SurfaceGrid grid = surface::GridOver(
        pipeline::AreaBelow(built.report.bounds, built.flight.frame, built.ground.MeanHeight()), cell_m);
    std::optional<surface::GroundSketch> below;
    if (is_ground_wanted) below.emplace(grid.columns, grid.rows, grid.cell_m);
    storage::SurfaceWriter writer(out_dir, built.flight.frame, built.report.bounds.Middle(), grid,
                                  built.ground.MeanHeight(), options.threads, below ? &*below : nullptr,
                                  progress, pipeline::RaisedM(built.report));
    if (const Result<void> begun = writer.Begin(); !begun) {
      if (begun.error().code != ErrorCode::kUnprocessable) return begun.error();
      ForgetHeights(out_dir);
      built.report.warnings.push_back(
          {flight::RemarkCode::kNoHeightFiles, {{"why", flight::WhyOf(begun.error())}}});
      return {};
    }
    const Result<void> put =
        matched != nullptr ? PutMatched(*matched, grid, writer)
                           : surface::MatchSurfaceBlocks(
                                 built.flight, photos, built.ground, grid, pipeline::SurfaceWithin(options),
                                 [&](surface::SurfaceBlock&& block) { return writer.Put(block); }, progress);
    if (!put) return put.error();
    std::error_code gone;  // what cannot be removed cannot be written either, which is said
    std::filesystem::remove(out_dir / "dsm_hillshade.tif", gone);  // of other heights
    SKYQUILT_TRY(writer.Publish());
    if (matched == nullptr) pipeline::TellSurface(cell_m, writer.MeasuredShare(), built.report);
    if (is_ground_wanted) {
      SKYQUILT_TRY_ASSIGN(built.report.surface->contour_interval_m,
                          storage::WriteContours(out_dir / "dtm.tif", surface::kSketchCellM, progress));
    }
    SKYQUILT_TRY(storage::WriteHillshade(out_dir / "dsm.tif", options.threads, progress));
  }
  built.report.timings.push_back(timing);
  return {};
}

}  // namespace skyquilt::server
