// SeamMap: the whole flight's decision on which photo shows what, made once before any block is rendered, so
// that no block depends on another: the cells' photos and what evens out the light across the seams.
// Immutable; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_grid.h"
#include "core/render/seams/seam_labels.h"
#include "core/render/seams/seam_levels.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

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
