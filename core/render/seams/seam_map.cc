#include "core/render/seams/seam_map.h"

#include <algorithm>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/geo/web_mercator.h"
#include "core/render/seams/label_seams.h"
#include "core/render/seams/low_res_view.h"
#include "core/render/seams/moving_objects.h"

namespace skyquilt::render {
namespace {

template <typename Read>
double MedianOf(const alignment::AlignedFlight& flight, Read read) {
  std::vector<double> values;
  for (const auto& photo : flight.photos) values.push_back(read(photo));
  if (values.empty()) return 1.0;
  return Median(std::move(values));
}

// An earlier run has labelled the very same cells for the very same photos.
bool IsDecided(const KnownLabels& known, const SeamGrid& grid, std::size_t photos) {
  const SeamGrid& before = known.grid;
  return known.photos == photos && before.zoom == grid.zoom && before.tile_size_px == grid.tile_size_px &&
         before.cell_px == grid.cell_px && before.first_column == grid.first_column &&
         before.first_row == grid.first_row && before.columns == grid.columns && before.rows == grid.rows;
}

// By photo: whether it may show some of the blocks, or blends into them; all without a choice of blocks.
std::vector<char> Wanted(const SeamMap& map, const MosaicPlan& plan, const std::vector<RenderBlock>* blocks,
                         std::size_t photos) {
  std::vector<char> wanted(photos, blocks == nullptr ? 1 : 0);
  if (blocks == nullptr) return wanted;
  for (const RenderBlock& block : *blocks) {
    for (const std::uint32_t photo : block.photos) wanted[photo] = 1;
    const Eigen::Vector2i corner = map.grid.CellOfBlock(block.tile, plan.block_levels);
    const int side = plan.BlockSizePx() / map.grid.cell_px;
    for (const std::uint32_t photo : map.PhotosIn(corner.x() - 1, corner.y() - 1, side + 2, side + 2))
      wanted[photo] = 1;
  }
  return wanted;
}

// By photo: whether it shows a cell that one of the wanted photos sees, and is none of those.
std::vector<char> Beside(const SeamLabels& labels, const std::vector<LowResView>& views,
                         const std::vector<char>& wanted) {
  std::vector<char> beside(views.size(), 0);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!wanted[i]) continue;
    const LowResView& view = views[i];
    for (int y = 0; y < view.rows; ++y) {
      for (int x = 0; x < view.columns; ++x) {
        const std::int32_t label = labels.At(view.column + x, view.row + y);
        if (label != kNoPhoto && !wanted[static_cast<std::size_t>(label)])
          beside[static_cast<std::size_t>(label)] = 1;
      }
    }
  }
  return beside;
}

}  // namespace

std::vector<std::uint32_t> SeamMap::PhotosIn(int column, int row, int columns, int rows) const {
  std::vector<std::uint32_t> photos;
  std::int32_t last = kNoPhoto;
  for (int y = row; y < row + rows; ++y) {
    for (int x = column; x < column + columns; ++x) {
      const std::int32_t label = labels.At(x, y);
      if (label == kNoPhoto || label == last) continue;
      last = label;
      const auto photo = static_cast<std::uint32_t>(label);
      const auto at = std::lower_bound(photos.begin(), photos.end(), photo);
      if (at == photos.end() || *at != photo) photos.insert(at, photo);
    }
  }
  return photos;
}

SeamMap BuildSeamMap(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                     const MosaicPlan& plan, const ExposureModel& exposure,
                     const std::vector<Thumbnail>& thumbnails, const SeamOptions& options) {
  SeamMap map;
  const double ground_per_merc = geo::GroundMetresPerMercMetre(flight.frame.origin().lat_deg);
  map.grid = MakeSeamGrid(
      plan,
      MedianOf(flight, [](const auto& p) { return std::max(p.intrinsics.width_px, p.intrinsics.height_px); }),
      ground_per_merc);
  map.cell_m = map.grid.CellInMercM() * ground_per_merc;
  std::vector<LowResView> views(flight.photos.size());
  const auto look = [&](std::size_t i) {
    views[i] = MakeLowResView(flight.photos[i], plan.seen_in_merc[i], flight.frame, ground, exposure.tones[i],
                              thumbnails[i], map.grid, plan.gsd_m);
  };
  if (options.known != nullptr && IsDecided(*options.known, map.grid, views.size())) {
    map.labels = options.known->labels;
    const std::vector<char> wanted = Wanted(map, plan, options.only_blocks, views.size());
    ParallelFor(views.size(), options.threads, [&](std::size_t i) {
      if (wanted[i]) look(i);
    });
    const std::vector<char> beside = Beside(map.labels, views, wanted);
    ParallelFor(views.size(), options.threads, [&](std::size_t i) {
      if (beside[i]) look(i);
    });
    map.levels = LevelSeams(views, map.labels, options.evens_light, options.threads, &wanted);
    return map;
  }
  ParallelFor(views.size(), options.threads, look);
  if (options.moves_seams) MarkMoving(views, map.cell_m, options.threads);
  const bool is_same_grid = options.known != nullptr && options.known->grid.zoom == map.grid.zoom &&
                            options.known->grid.tile_size_px == map.grid.tile_size_px &&
                            options.known->grid.cell_px == map.grid.cell_px;
  map.labels = LabelSeams(
      views, map.grid,
      {options.moves_seams, MedianOf(flight, [](const auto& p) { return p.height_above_ground_m; }),
       is_same_grid ? options.known : nullptr});
  map.levels = LevelSeams(views, map.labels, options.evens_light, options.threads);
  return map;
}

}  // namespace skyquilt::render
