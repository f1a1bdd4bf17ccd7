// LowResView: what one photo shows of the ground, cell by cell of the seam grid: colours with the exposure
// evened out, how well each cell is seen. Frames: cells of SeamGrid, enu. A value; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/seams/seam_grid.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

enum class Seen : std::uint8_t { kNot, kPartly, kFully };

struct LowResView {
  int column = 0, row = 0;  // of its first cell in the grid
  int columns = 0, rows = 0;
  std::vector<Seen> seen;
  std::vector<std::array<std::uint8_t, 3>> rgb;  // 0 where not seen
  std::vector<float> score_m;                    // ViewScore
  std::vector<bool> is_moving;                   // shows a moving object (MarkMoving); empty: nothing known
  float camera_east_m = 0.0f, camera_north_m = 0.0f;  // in enu

  // Index of a grid cell; -1 outside.
  int IndexOf(int grid_column, int grid_row) const {
    const int x = grid_column - column, y = grid_row - row;
    return x < 0 || y < 0 || x >= columns || y >= rows ? -1 : y * columns + x;
  }
};

// `seen_in_merc` bounds what the photo sees; `map_gsd_m` is what most photos show a pixel of.
LowResView MakeLowResView(const alignment::AlignedPhoto& photo, const geo::Bounds2& seen_in_merc,
                          const geo::LocalFrame& frame, const ground::GroundSurface& ground,
                          const PhotoTone& tone, const Thumbnail& thumbnail, const SeamGrid& grid,
                          double map_gsd_m);

}  // namespace skyquilt::render
