#include "core/surface/match_surface.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/base/trace.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/surface/match_block.h"

namespace skyquilt::surface {
namespace {

constexpr double kTieShare = 0.002;  // of tie points may lie outside the range on either side
constexpr double kTieRoomM = 1.0;    // and what they show of is a little higher
constexpr double kMinRangeM = 0.5;
constexpr std::size_t kBlocksThatWait = 4;

// One for each thread at work.
class SpareBlockMemory {
 public:
  std::unique_ptr<BlockMemory> Take() {
    std::lock_guard lock(mutex_);
    if (spare_.empty()) return std::make_unique<BlockMemory>();
    std::unique_ptr<BlockMemory> memory = std::move(spare_.back());
    spare_.pop_back();
    return memory;
  }
  void Give(std::unique_ptr<BlockMemory> memory) {
    std::lock_guard lock(mutex_);
    spare_.push_back(std::move(memory));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<BlockMemory>> spare_;
};

struct Placed {
  std::uint64_t along = 0;
  CellBox box;
};

std::vector<CellBox> BlocksOf(const SurfaceGrid& grid, int block_cells) {
  const int across = (grid.columns + block_cells - 1) / block_cells,
            up = (grid.rows + block_cells - 1) / block_cells;
  const int order = std::bit_width(static_cast<unsigned>(std::max(across, up)));
  std::vector<Placed> placed;
  for (int row = 0; row < up; ++row) {
    for (int column = 0; column < across; ++column) {
      const int left = column * block_cells, low = row * block_cells;
      placed.push_back(
          {geo::HilbertIndex(order, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)),
           {left, low, std::min(block_cells, grid.columns - left), std::min(block_cells, grid.rows - low)}});
    }
  }
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) { return a.along < b.along; });
  std::vector<CellBox> blocks;
  blocks.reserve(placed.size());
  for (const Placed& block : placed) blocks.push_back(block.box);
  return blocks;
}

template <typename T>
void CopyRows(const std::vector<T>& from, const CellBox& box, int columns, std::vector<T>& to) {
  for (int row = 0; row < box.rows; ++row) {
    std::copy_n(from.data() + static_cast<std::size_t>(row) * box.columns, box.columns,
                to.data() + static_cast<std::size_t>(box.row + row) * columns + box.column);
  }
}

}  // namespace

SurfaceGrid GridOver(const geo::Bounds2& area_in_enu, double cell_m) {
  SurfaceGrid grid;
  grid.cell_m = cell_m;
  const Eigen::Vector2d first = (area_in_enu.min / cell_m).array().floor(),
                        last = (area_in_enu.max / cell_m).array().ceil();
  grid.south_west_in_enu = first * cell_m;
  grid.columns = static_cast<int>(last.x() - first.x()) + 1;
  grid.rows = static_cast<int>(last.y() - first.y()) + 1;
  return grid;
}

HeightRange RangeAbout(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       const SurfaceOptions& options) {
  std::vector<double> heights, off;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    if (photo.placement == alignment::Placement::kAligned) heights.push_back(photo.height_above_ground_m);
  }
  const double most_m =
      options.most_share_of_height * std::max(1.0, MedianIfAny(std::move(heights)).value_or(1.0));
  for (const Eigen::Vector3d& point : flight.tie_points_in_enu) {
    const double off_m = point.z() - ground.HeightAt(point.head<2>());
    if (std::abs(off_m) < most_m) off.push_back(off_m);
  }
  const double lowest_m = off.empty() ? 0.0 : kTieRoomM - Percentile(off, kTieShare);
  const double highest_m = off.empty() ? 0.0 : kTieRoomM + Percentile(off, 1.0 - kTieShare);
  const auto within = [&](double asked_m, double shown_m) {
    return std::clamp(std::max(asked_m, shown_m), std::min(kMinRangeM, most_m), most_m);
  };
  return {within(options.below_ground_m, lowest_m), within(options.above_ground_m, highest_m)};
}

Result<void> MatchSurfaceBlocks(const alignment::AlignedFlight& flight, const flight::PhotoSource& source,
                                const ground::GroundSurface& ground, const SurfaceGrid& grid,
                                const SurfaceOptions& options, const TakeSurfaceBlock& take,
                                Progress& progress) {
  if (grid.columns < 1 || grid.rows < 1 || !(grid.cell_m > 0.0) || options.block_cells < 1) {
    return Error{ErrorCode::kInvalidArgument, "A surface needs at least one cell.", ""};
  }
  const Error cancelled{ErrorCode::kCancelled, "The job was cancelled.", ""};
  const HeightRange range = RangeAbout(flight, ground, options);
  const std::vector<SurfaceCamera> cameras = SurfaceCameras(flight, ground, range.below_m, range.above_m);
  GrayPhotos photos(source, kSurfaceLevels, options.photo_budget_bytes);
  const MatchContext context{flight, cameras, ground, grid, options, range.below_m, range.above_m, photos};
  const std::vector<CellBox> blocks = BlocksOf(grid, options.block_cells);
  const std::size_t window = kBlocksThatWait * static_cast<std::size_t>(ThreadCount(options.threads));
  SpareBlockMemory spare;
  std::optional<Error> error;
  std::atomic<bool> stopped{false};
  ParallelOrdered<SurfaceBlock>(
      blocks.size(), options.threads, window,
      [&](std::size_t i) {
        if (stopped || progress.IsCancelled()) {
          stopped = true;
          return SurfaceBlock{};
        }
        const TraceSpan span("match heights");
        std::unique_ptr<BlockMemory> memory = spare.Take();
        SurfaceBlock block = MatchBlock(context, blocks[i], *memory);
        spare.Give(std::move(memory));
        return block;
      },
      [&](std::size_t i, SurfaceBlock&& block) {
        if (error) return;
        if (block.box.columns == 0) {
          error = cancelled;
          return;
        }
        if (const Result<void> taken = take(std::move(block)); !taken) {
          error = taken.error();
          stopped = true;
          return;
        }
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(blocks.size()), "matching heights");
      });
  if (error) return *error;
  return {};
}

Result<DenseSurface> MatchSurface(const alignment::AlignedFlight& flight, const flight::PhotoSource& source,
                                  const ground::GroundSurface& ground, const SurfaceGrid& grid,
                                  const SurfaceOptions& options, Progress& progress) {
  DenseSurface surface{grid, {}};
  const std::size_t cells =
      static_cast<std::size_t>(std::max(0, grid.columns)) * static_cast<std::size_t>(std::max(0, grid.rows));
  surface.cells.heights_m.resize(cells);
  surface.cells.confidence.resize(cells);
  surface.cells.agreeing_photos.resize(cells);
  SKYQUILT_TRY(MatchSurfaceBlocks(
      flight, source, ground, grid, options,
      [&](SurfaceBlock&& block) -> Result<void> {
        CopyRows(block.cells.heights_m, block.box, grid.columns, surface.cells.heights_m);
        CopyRows(block.cells.confidence, block.box, grid.columns, surface.cells.confidence);
        CopyRows(block.cells.agreeing_photos, block.box, grid.columns, surface.cells.agreeing_photos);
        return {};
      },
      progress));
  return surface;
}

}  // namespace skyquilt::surface
