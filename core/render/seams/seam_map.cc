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
  ParallelFor(views.size(), options.threads, [&](std::size_t i) {
    views[i] = MakeLowResView(flight.photos[i], plan.seen_in_merc[i], flight.frame, ground,
                              exposure.photos[i], thumbnails[i], map.grid, plan.gsd_m);
  });
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
