#include "storage/exports/warped/warp_tiles.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/streamed/cog_cells.h"
#include "storage/exports/tiff_head.h"
#include "storage/exports/warped/block_pyramid.h"
#include "storage/exports/warped/resample_block.h"
#include "storage/exports/warped/source_window.h"
#include "storage/exports/warped/target_grid.h"
#include "storage/files/publish_file.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

// Blocks that one thread makes together are those below one of this level: tiles are decoded once for them
// all.
constexpr std::size_t kUnitLevel = 2;
// Of a window for them; where the grids are turned against each other each block has one of its own.
constexpr std::int64_t kMaxWindowPx = std::int64_t{24} << 20;

struct EncodedBlock {
  BlockId id;
  std::string bytes;  // as the file has them: picture and mask, framed
  std::uint64_t image_bytes = 0, mask_bytes = 0;
};

struct Unit {
  std::vector<EncodedBlock> blocks;
  std::optional<image::RgbaImage> top;
};

// More would not be quicker, and each has windows of its own.
constexpr int kMaxThreads = 8;

// The coarsest zoom whose pixels are not larger than the target's.
SourceLevel LevelFor(double pixel_in_merc_m, const WarpTilesOptions& options, int tile_size_px) {
  constexpr double kNearly = 1.0 + 1e-6;
  int zoom = options.max_zoom;
  while (zoom > options.min_zoom &&
         geo::PixelSizeInMercM(zoom - 1, tile_size_px) <= pixel_in_merc_m * kNearly)
    --zoom;
  return {zoom, tile_size_px};
}

struct Warper {
  MapTiles& tiles;
  const TargetGrid& grid;
  SourceLevel source;
  double source_px_per_m;
  SourceReach reach;
  // All that there is, for a source that no tiles are as coarse as; null: tiles are.
  const SourceWindow* whole;
  const ResamplingKernel& kernel;
  const std::vector<GridLevel>& levels;
  const CogCells& cells;

  Result<Unit> Make(const BlockId& top) const {
    Unit unit;
    std::optional<SourceWindow> window;
    if (whole == nullptr) {
      SKYQUILT_TRY_ASSIGN(window, WindowBelow(top));
    }
    SKYQUILT_TRY_ASSIGN(unit.top, MakeBlock(top, window ? &*window : whole, unit));
    return unit;
  }

  EncodedBlock Encode(const BlockId& id, const image::RgbaImage& pixels) const {
    const CogCell cell = cells.Encode(pixels);
    EncodedBlock block{id, {}, cell.image.size(), cell.mask.size()};
    if (cell.image.empty()) return block;
    AppendBlock(cell.image, block.bytes);
    AppendBlock(cell.mask, block.bytes);
    return block;
  }

  Result<std::optional<image::RgbaImage>> MakeBlock(const BlockId& id, const SourceWindow* window,
                                                    Unit& unit) const {
    std::optional<image::RgbaImage> pixels;
    if (id.level == 0) {
      SKYQUILT_TRY_ASSIGN(pixels, Resampled(id, window));
    } else {
      std::vector<std::optional<image::RgbaImage>> children(4);
      for (int i = 0; i < 4; ++i) {
        if (!IsWithin(levels, id.Child(i))) continue;
        SKYQUILT_TRY_ASSIGN(children[static_cast<std::size_t>(i)], MakeBlock(id.Child(i), window, unit));
      }
      pixels = Above(children);
    }
    if (pixels) unit.blocks.push_back(Encode(id, *pixels));
    return pixels;
  }

  Result<std::optional<image::RgbaImage>> Resampled(const BlockId& id, const SourceWindow* window) const {
    std::optional<SourceWindow> own;
    if (window == nullptr) {
      SKYQUILT_TRY_ASSIGN(own, WindowBelow(id));
      if (!own) return TargetGrid::Unreachable(grid.place().epsg);
      window = &*own;
    }
    const std::vector<Eigen::Vector2d> places = PlacesIn(id, kStepsOfBlock);
    BlockCorners corners;
    const Eigen::Vector2d corner(static_cast<double>(window->left_px), static_cast<double>(window->top_px));
    for (std::size_t j = 0; j < corners.size(); ++j) {
      for (std::size_t i = 0; i < corners[j].size(); ++i)
        corners[j][i] = places[j * corners[j].size() + i] - corner;
    }
    auto block = image::RgbaImage::Transparent(kWarpedBlockPx, kWarpedBlockPx);
    if (!ResampleBlock(*window, corners, kernel, block)) return std::optional<image::RgbaImage>();
    return std::optional(std::move(block));
  }

  // In the source's pixels: of the corners of so many steps across and down a block of the finest level.
  std::vector<Eigen::Vector2d> PlacesIn(const BlockId& finest, int steps) const {
    std::vector<Eigen::Vector2d> places = grid.CornersInMerc(
        finest.column * kWarpedBlockPx, finest.row * kWarpedBlockPx, kWarpedStepPx, steps + 1, steps + 1);
    for (Eigen::Vector2d& place : places) {
      place = Eigen::Vector2d(place.x() + geo::kMercHalfWidthM, geo::kMercHalfWidthM - place.y()) *
              source_px_per_m;
    }
    return places;
  }

  // What lies below all blocks below one, as far as there is something; nothing where it would be too large.
  Result<std::optional<SourceWindow>> WindowBelow(const BlockId& block) const {
    const std::int64_t side = std::int64_t{1} << block.level;
    geo::Bounds2 below;
    for (const Eigen::Vector2d& place :
         PlacesIn({0, block.column * side, block.row * side}, kStepsOfBlock * static_cast<int>(side))) {
      if (place.allFinite()) below.Include(place);
    }
    const SourceReach window = reach.Within(below, kernel.size() + 1.0);
    if (window.IsLargerThan(kMaxWindowPx)) return std::optional<SourceWindow>();
    SKYQUILT_TRY_ASSIGN(SourceWindow loaded, LoadWindow(tiles, source, window));
    return std::optional(std::move(loaded));
  }
};

Error Cancelled() { return {ErrorCode::kCancelled, "The job was cancelled.", ""}; }

// Where the encoded blocks lie in the spool.
struct Kept {
  std::uint64_t at = 0, image_bytes = 0, mask_bytes = 0;
  bool is_there() const { return image_bytes > 0; }
};
using KeptLevels = std::vector<std::vector<Kept>>;

Result<void> Keep(const EncodedBlock& block, const std::vector<GridLevel>& levels, BlockSpool& spool,
                  KeptLevels& kept) {
  if (block.bytes.empty()) return {};
  const std::int64_t cell = block.id.row * levels[block.id.level].columns + block.id.column;
  kept[block.id.level][static_cast<std::size_t>(cell)] = {spool.length(), block.image_bytes,
                                                          block.mask_bytes};
  return spool.Append(block.bytes);
}

// The smallest overview first, and each level row by row, as readers expect it.
Result<void> WriteFile(const std::filesystem::path& path, const std::vector<GridLevel>& levels,
                       const TiffPlace& place, BlockSpool& spool, const KeptLevels& kept,
                       const Progress& progress) {
  SKYQUILT_TRY(spool.Flush());
  std::uint64_t bytes = spool.length();
  for (const auto& level : kept) bytes += 64 * level.size();
  TiffHead head(levels, kWarpedBlockPx, TiffTiles::kJpeg, bytes, place);
  SKYQUILT_TRY_ASSIGN(auto file, StreamFile::Create(path));
  file->Write(head.bytes());
  for (std::size_t level = levels.size(); level-- > 0;) {
    for (std::size_t cell = 0; cell < kept[level].size(); ++cell) {
      const Kept& block = kept[level][cell];
      if (!block.is_there()) continue;
      if (progress.IsCancelled()) return Cancelled();
      const std::uint64_t at = file->position();
      const auto number = static_cast<std::int64_t>(cell);
      const std::uint64_t both = block.image_bytes + block.mask_bytes + 2 * kBlockFrameBytes;
      SKYQUILT_TRY_ASSIGN(const std::string framed, spool.Read(block.at, both));
      file->Write(framed);
      head.SetTile(level, number, at + kBlockSizeBytes, block.image_bytes);
      head.SetMask(level, number, at + kBlockFrameBytes + block.image_bytes + kBlockSizeBytes,
                   block.mask_bytes);
    }
  }
  file->WriteAt(0, head.bytes());
  return file->Publish();
}

}  // namespace

Result<void> WarpTiles(MapTiles& tiles, const std::filesystem::path& path, const WarpTilesOptions& options,
                       Progress& progress) {
  const int tile_size_px = TilesetNumber(tiles.metadata(), "tile_size", 256);
  SKYQUILT_TRY_ASSIGN(const auto grid, TargetGrid::Cover(options.bounds, options.target.epsg,
                                                         options.target.pixel_x, options.target.pixel_y));
  const SourceLevel source = LevelFor(grid->PixelInMercM(), options, tile_size_px);
  // Of a map whose coarsest tiles are still finer than that, coarser pixels are made of all of them.
  double ratio = grid->PixelInMercM() / geo::PixelSizeInMercM(source.zoom, tile_size_px);
  double source_px_per_m = 1.0 / geo::PixelSizeInMercM(source.zoom, tile_size_px);
  const SourceReach reach = SourceReach::Of(options.bounds, source_px_per_m);
  std::optional<SourceWindow> whole;
  int halvings = 0;
  for (; ratio >= 2.0; ratio /= 2.0, source_px_per_m /= 2.0) ++halvings;
  if (halvings > 0) {
    if (reach.IsLargerThan(kMaxWindowPx)) return TargetGrid::Unreachable(options.target.epsg);
    SKYQUILT_TRY_ASSIGN(whole, LoadHalved(tiles, source, reach, halvings));
  }
  const ResamplingKernel kernel =
      options.target.is_coarser ? ResamplingKernel::Average(ratio) : ResamplingKernel::Cubic(ratio);
  const std::vector<GridLevel> levels = LevelsOver(grid->width_px(), grid->height_px());
  const CogCells cells(TiffTiles::kJpeg, kWarpedBlockPx, options.jpeg_quality);
  const Warper warper{tiles,  *grid,  source, source_px_per_m, reach, whole ? &*whole : nullptr,
                      kernel, levels, cells};

  std::filesystem::path beside = path;
  beside += ".blocks.tmp";
  SKYQUILT_TRY_ASSIGN(const auto spool, BlockSpool::Create(beside));
  KeptLevels kept;
  for (const GridLevel& level : levels) kept.emplace_back(static_cast<std::size_t>(level.CellCount()));
  Overviews overviews(levels, [&](const BlockId& id, const std::optional<image::RgbaImage>& pixels) {
    return pixels ? Keep(warper.Encode(id, *pixels), levels, *spool, kept) : Result<void>();
  });
  const std::vector<BlockId> units = InQuarters(levels, std::min(kUnitLevel, levels.size() - 1));
  std::optional<Error> failure;
  std::atomic<bool> has_failed = false;
  const int threads = std::min(ThreadCount(options.threads), kMaxThreads);
  ParallelOrdered<Result<Unit>>(
      units.size(), threads, static_cast<std::size_t>(threads) + 1,
      [&](std::size_t i) -> Result<Unit> {
        if (has_failed || progress.IsCancelled()) return Cancelled();
        return warper.Make(units[i]);
      },
      [&](std::size_t i, Result<Unit>&& unit) {
        if (failure) return;
        const auto take = [&]() -> Result<void> {
          if (!unit) return unit.error();
          for (const EncodedBlock& block : unit->blocks) SKYQUILT_TRY(Keep(block, levels, *spool, kept));
          return overviews.Add(units[i], std::move(unit->top));
        };
        if (const Result<void> taken = take(); !taken) {
          failure = taken.error();
          has_failed = true;
          return;
        }
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(units.size()), options.message);
      });
  if (failure) return *failure;
  if (spool->length() == 0)
    return Error{ErrorCode::kCorrupt,
                 "The map has no tiles where it says that it has some. Make or import it again.", ""};
  return WriteFile(path, levels, grid->place(), *spool, kept, progress);
}

Result<int> UtmEpsg(const geo::LatLon& position) {
  if (!geo::IsWithinUtm(position))
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailBeyondUtm);
  return geo::UtmCodeOf(position);
}

Result<void> WriteUtmGeotiff(const std::filesystem::path& mbtiles, const std::filesystem::path& path,
                             WarpTilesOptions options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(options.target.epsg, UtmEpsg(options.bounds.Middle()));
  options.message = "writing the UTM GeoTIFF";
  SKYQUILT_TRY_ASSIGN(const auto tiles, MbtilesReader::Open(mbtiles));
  return WarpTiles(*tiles, path, options, progress);
}

}  // namespace skyquilt::storage
