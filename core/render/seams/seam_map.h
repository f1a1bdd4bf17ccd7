// SeamMap: the whole flight's decision on which photo shows what, made once before any block is rendered, so
// that no block depends on another: the cells' photos and what evens out the light across the seams.
// Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_grid.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

// What is added to a photo near its seams so that brightness and colour pass smoothly from one photo to the
// next, cell by cell of its view: the low band of a two-band blend, kept on the seam grid. At a seam both
// sides come to the same mean; away from it the photo is left alone. Differences of content (a leaning roof,
// a car) are not light and are left out. Source: the two-band split of Brown and Lowe, Automatic panoramic
// image stitching (2007), with the low band as a correction field.
struct PhotoLevels : CellWindow {
  std::vector<bool> sees_whole;                      // the photo's edge is not near the cell
  std::vector<std::array<std::int16_t, 3>> eighths;  // of a grey level; empty: no correction

  bool SeesWhole(int grid_column, int grid_row) const {
    const int cell = IndexOf(grid_column, grid_row);
    return cell >= 0 && sees_whole[static_cast<std::size_t>(cell)];
  }

  // Grey levels to add; 0 outside.
  std::array<float, 3> At(int grid_column, int grid_row) const {
    const int cell = IndexOf(grid_column, grid_row);
    if (cell < 0 || eighths.empty()) return {};
    const auto& [red, green, blue] = eighths[static_cast<std::size_t>(cell)];
    return {0.125f * red, 0.125f * green, 0.125f * blue};
  }
};

struct SeamOptions {
  bool moves_seams = true;  // false: every cell takes the photo that stood most nearly above it
  bool evens_light = true;
  int threads = 0;
  const KnownLabels* known = nullptr;  // of an earlier run; not used where its cells are of another size
  // Where all photos are known: only what these blocks of the plan need is worked out; levels of photos that
  // they do not show stay empty.
  const std::vector<RenderBlock>* only_blocks = nullptr;
};

struct SeamMap {
  SeamGrid grid;
  SeamLabels labels;
  std::vector<PhotoLevels> levels;  // by photo
  double cell_m = 1.0;              // on the ground

  // Photos that show any of the cells, rising; the rectangle may reach beyond the grid.
  std::vector<std::uint32_t> PhotosIn(int column, int row, int columns, int rows) const;
};

// thumbnails[i] belongs to flight.photos[i].
SeamMap BuildSeamMap(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                     const MosaicPlan& plan, const ExposureModel& exposure,
                     const std::vector<Thumbnail>& thumbnails, const SeamOptions& options);

}  // namespace skyquilt::render
