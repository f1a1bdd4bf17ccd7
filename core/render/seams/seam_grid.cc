#include "core/render/seams/seam_grid.h"

#include <cmath>

#include "core/base/check.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::render {
namespace {

// Fine enough for a seam to go round a car, coarse enough for the whole flight's cells to fit in memory.
constexpr double kCellsAcrossPhoto = 128.0;
constexpr int kFinestCellPx = 4, kCoarsestCellPx = 64;
// A view towards the horizon must not make its cells too many.
constexpr double kMaxCellsAPhoto = 1 << 20;
// The whole grid's: eight bytes for each chunk of labels, whether the flight reaches there or not.
constexpr double kMaxCellsOfGrid = std::int64_t{1} << 34;
constexpr int kHugeCellPx = 1024;  // where 64 are not enough for that

}  // namespace

double SeamGrid::CellInMercM() const { return geo::PixelSizeInMercM(zoom, tile_size_px) * cell_px; }

Eigen::Vector2d SeamGrid::CellInMerc(int column, int row) const {
  const double cell_m = CellInMercM();
  return {(static_cast<double>(first_column + column) + 0.5) * cell_m - geo::kMercHalfWidthM,
          geo::kMercHalfWidthM - (static_cast<double>(first_row + row) + 0.5) * cell_m};
}

Eigen::Vector2i SeamGrid::CellOfBlock(const geo::TileId& block_tile, int block_levels) const {
  const std::int64_t cells_a_block = (static_cast<std::int64_t>(tile_size_px) << block_levels) / cell_px;
  const std::int64_t cells_a_world = cells_a_block << block_tile.z();
  std::int64_t column = block_tile.x() * cells_a_block;
  while (column + cells_a_block <= first_column) column += cells_a_world;
  while (column >= first_column + columns) column -= cells_a_world;
  return {static_cast<int>(column - first_column),
          static_cast<int>(block_tile.y() * cells_a_block - first_row)};
}

SeamGrid MakeSeamGrid(const MosaicPlan& plan, double photo_side_px, double ground_per_merc) {
  SeamGrid grid;
  grid.zoom = plan.base_zoom;
  grid.tile_size_px = plan.tile_size_px;
  const double pixel_in_merc_m = geo::PixelSizeInMercM(grid.zoom, grid.tile_size_px);
  const double wanted_px =
      photo_side_px / kCellsAcrossPhoto * plan.gsd_m / (pixel_in_merc_m * ground_per_merc);
  grid.cell_px = kFinestCellPx;
  while (grid.cell_px < kCoarsestCellPx && 1.5 * grid.cell_px < wanted_px) grid.cell_px *= 2;
  const double grid_m2 = plan.bounds_in_merc.Width() * plan.bounds_in_merc.Height();
  double widest_m2 = 0.0, all_m2 = 0.0;
  for (const geo::Bounds2& seen : plan.seen_in_merc) {
    if (seen.IsEmpty()) continue;
    widest_m2 = std::max(widest_m2, seen.Width() * seen.Height());
    all_m2 += seen.Width() * seen.Height();
  }
  const auto is_too_fine = [&](double max_a_photo) {
    const double cell_m2 = std::pow(grid.CellInMercM(), 2);
    return widest_m2 > max_a_photo * cell_m2 || grid_m2 > kMaxCellsOfGrid * cell_m2 ||
           all_m2 > static_cast<double>(plan.max_seam_cells) * cell_m2;
  };
  while (grid.cell_px < kCoarsestCellPx && is_too_fine(kMaxCellsAPhoto)) grid.cell_px *= 2;
  const int max_px = std::min(kHugeCellPx, plan.BlockSizePx());
  while (grid.cell_px < max_px && is_too_fine(4.0 * kMaxCellsAPhoto)) grid.cell_px *= 2;
  const double cell_m = grid.CellInMercM();
  const geo::Bounds2& bounds = plan.bounds_in_merc;
  grid.first_column =
      static_cast<std::int64_t>(std::floor((bounds.min.x() + geo::kMercHalfWidthM) / cell_m)) - 1;
  grid.first_row =
      static_cast<std::int64_t>(std::floor((geo::kMercHalfWidthM - bounds.max.y()) / cell_m)) - 1;
  grid.columns = static_cast<int>(bounds.Width() / cell_m) + 4;
  grid.rows = static_cast<int>(bounds.Height() / cell_m) + 4;
  return grid;
}

SeamLabels::SeamLabels(int columns, int rows)
    : columns_(columns),
      rows_(rows),
      chunk_columns_(static_cast<std::size_t>(columns + kChunk - 1) / kChunk) {
  chunks_.resize(chunk_columns_ * (static_cast<std::size_t>(rows + kChunk - 1) / kChunk));
}

SeamLabels::SeamLabels(const SeamLabels& other)
    : columns_(other.columns_), rows_(other.rows_), chunk_columns_(other.chunk_columns_) {
  chunks_.reserve(other.chunks_.size());
  for (const auto& chunk : other.chunks_)
    chunks_.push_back(chunk ? std::make_unique<Chunk>(*chunk) : nullptr);
}

SeamLabels& SeamLabels::operator=(const SeamLabels& other) { return *this = SeamLabels(other); }

void SeamLabels::Set(int column, int row, std::int32_t photo) {
  SKYQUILT_CHECK(column >= 0 && row >= 0 && column < columns_ && row < rows_, "a cell outside the seam grid");
  std::unique_ptr<Chunk>& chunk = chunks_[ChunkOf(column, row)];
  if (!chunk) {
    chunk = std::make_unique<Chunk>();
    chunk->fill(kNoPhoto);
  }
  (*chunk)[Within(column, row)] = photo;
}

}  // namespace skyquilt::render
