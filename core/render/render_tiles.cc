#include "core/render/render_tiles.h"

#include <fmt/core.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/trace.h"
#include "core/geo/web_mercator.h"
#include "core/pyramid/build_overviews.h"
#include "core/pyramid/tile_image.h"
#include "core/render/blocks/block_digest.h"
#include "core/render/blocks/block_weights.h"

namespace skyquilt::render {
namespace {

struct FinishedTile {
  geo::TileId tile;
  pyramid::EncodedTile encoded;
};

struct FinishedBlock {
  std::optional<Error> error;
  std::optional<Digest> digest;  // of what it was made from; only where somebody remembers
  bool is_kept = false;          // an earlier run made it: nothing below but the digest
  bool has_png_fringe = false;   // it did, with PNG where WebP is wanted
  std::vector<FinishedTile>
      tiles;  // base zoom first, then the block's own overviews but the topmost's parents
  std::optional<image::RgbaImage> half;  // the block as half a tile; nothing if no pixel is covered
  std::int64_t base_tiles = 0;
  std::int64_t covered_pixels = 0;
  geo::Bounds2 covered_in_merc;
};

void MeasureCoverage(const image::RgbaImage& image, const RenderBlock& block, const MosaicPlan& plan,
                     FinishedBlock& finished) {
  const int size_px = plan.BlockSizePx();
  int x0 = size_px, y0 = size_px, x1 = -1, y1 = -1;
  for (int y = 0; y < size_px; ++y) {
    const std::uint8_t* alpha = image.Pixel(0, y) + 3;
    int covered = 0;
    for (int x = 0; x < size_px; ++x) covered += alpha[4 * x] != 0 ? 1 : 0;
    if (covered == 0) continue;
    finished.covered_pixels += covered;
    int first = 0, last = size_px - 1;
    while (alpha[4 * first] == 0) ++first;
    while (alpha[4 * last] == 0) --last;
    x0 = std::min(x0, first), x1 = std::max(x1, last);
    y0 = std::min(y0, y), y1 = y;
  }
  if (x1 < 0) return;
  geo::Bounds2 bounds = block.tile.BoundsInMerc();
  // The other side of the date line is next door.
  const double middle_x = 0.5 * (plan.bounds_in_merc.min.x() + plan.bounds_in_merc.max.x());
  const double world_m = 2.0 * geo::kMercHalfWidthM;
  const double turn_m = world_m * std::round((middle_x - bounds.min.x()) / world_m);
  bounds.min.x() += turn_m;
  bounds.max.x() += turn_m;
  const double pixel_m = geo::PixelSizeInMercM(block.tile.z(), size_px);
  finished.covered_in_merc.Include(
      Eigen::Vector2d(bounds.min.x() + x0 * pixel_m, bounds.max.y() - y0 * pixel_m));
  finished.covered_in_merc.Include(
      Eigen::Vector2d(bounds.min.x() + (x1 + 1) * pixel_m, bounds.max.y() - (y1 + 1) * pixel_m));
}

double CoveredM2(const pyramid::KeptBlock& block, double pixel_in_merc_m) {
  if (block.covered_in_merc.IsEmpty()) return 0.0;
  const geo::Bounds2& covered = block.covered_in_merc;
  const geo::LatLon middle = geo::LatLonFromMerc(0.5 * (covered.min + covered.max));
  return static_cast<double>(block.covered_pixels) * pixel_in_merc_m * pixel_in_merc_m *
         geo::GroundPerMercArea(middle.lat_deg);
}

FinishedBlock FinishBlock(const RenderContext& context, const RenderOptions& options,
                          const RenderBlock& block, const BlockGeometry& geometry) {
  FinishedBlock finished;
  Result<image::RgbaImage> rendered = [&] {
    const TraceSpan span("render block");
    return RenderBlockPixels(context, block, geometry);
  }();
  if (!rendered) {
    finished.error = rendered.error();
    return finished;
  }
  image::RgbaImage image = *std::move(rendered);
  MeasureCoverage(image, block, context.plan, finished);
  if (finished.covered_pixels == 0) return finished;
  const TraceSpan span("encode tiles");
  const int tile_px = context.plan.tile_size_px;
  for (int level = context.plan.block_levels; level >= 0; --level) {
    const int side = 1 << level;
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        auto encoded = pyramid::EncodeTile(image, column * tile_px, row * tile_px, tile_px, options.encode);
        if (!encoded) continue;
        const auto tile =
            geo::TileId::Make(block.tile.z() + level, (std::int64_t{block.tile.x()} << level) + column,
                              (std::int64_t{block.tile.y()} << level) + row);
        if (level == context.plan.block_levels) ++finished.base_tiles;
        finished.tiles.push_back({*tile, *std::move(encoded)});
      }
    }
    if (level > 0) image = pyramid::Halve(image);
  }
  // Of coverage too thin to show nothing was stored.
  if (finished.tiles.empty() || finished.tiles.back().tile != block.tile) return finished;
  Result<image::RgbaImage> half = pyramid::HalfOfTile(finished.tiles.back().encoded.bytes, tile_px);
  if (half) {
    finished.half = *std::move(half);
  } else {
    finished.error = half.error();
  }
  return finished;
}

// By block, the photos that no later one shows.
std::vector<std::vector<std::uint32_t>> LastShown(const RenderContext& context) {
  const std::vector<RenderBlock>& blocks = context.plan.blocks;
  std::vector<std::vector<std::uint32_t>> last(blocks.size());
  std::vector<bool> is_known(context.flight.photos.size(), false);
  for (std::size_t i = blocks.size(); i-- > 0;) {
    const BlockCells cells(context.seams, blocks[i].tile, context.plan.block_levels);
    for (const std::uint32_t photo : cells.PhotosOf(blocks[i])) {
      if (!is_known[photo]) last[i].push_back(photo);
      is_known[photo] = true;
    }
  }
  return last;
}

// Puts the tiles of a block, newly made or an earlier run's, and says what the rest of the map needs of it.
template <typename Put>
Result<pyramid::KeptBlock> TakeOver(const MosaicPlan& plan, const geo::TileId& tile,
                                    const FinishedBlock& block, const pyramid::EncodeOptions& encode,
                                    const RenderMemory* memory, const Put& put) {
  if (block.is_kept) {
    return memory->map.Reuse(tile, *block.digest,
                             block.has_png_fringe ? std::optional(encode.quality) : std::nullopt);
  }
  for (const FinishedTile& finished : block.tiles) put(finished.tile, finished.encoded);
  pyramid::KeptBlock kept{plan.block_levels,     static_cast<std::int64_t>(block.tiles.size()),
                          block.base_tiles,      block.covered_pixels,
                          block.covered_in_merc, {}};
  if (memory == nullptr) return kept;
  if (const Result<void> remembered = memory->map.Keep(tile, *block.digest, kept); !remembered)
    return remembered.error();
  return kept;
}

}  // namespace

Result<RenderReport> RenderTiles(const RenderContext& context, const RenderOptions& options,
                                 pyramid::TileSink& sink, Progress& progress, const RenderMemory* memory) {
  RenderReport report;
  std::optional<Error> failure;
  std::atomic<bool> stop{false};
  const auto put = [&](const geo::TileId& tile, const pyramid::EncodedTile& encoded) {
    if (failure) return;
    if (auto stored = sink.Put(tile, encoded.format, encoded.bytes); !stored) {
      failure = stored.error();
      stop = true;
      return;
    }
    ++report.tiles;
  };
  const int block_zoom = context.plan.base_zoom - context.plan.block_levels;
  pyramid::OverviewBuilder overviews(block_zoom, std::min(context.plan.min_zoom, block_zoom),
                                     context.plan.tile_size_px,
                                     [&](const geo::TileId& tile, const image::RgbaImage& image) {
                                       if (auto encoded = pyramid::EncodeTile(image, options.encode))
                                         put(tile, *encoded);
                                     });
  const double pixel_m = geo::PixelSizeInMercM(context.plan.base_zoom, context.plan.tile_size_px);
  const std::size_t count = context.plan.blocks.size();
  const std::optional<Digest> steps = memory != nullptr && context.ground.HasSteps()
                                          ? std::optional(DigestSteps(context.ground))
                                          : std::nullopt;
  const std::vector<std::vector<std::uint32_t>> last_shown = LastShown(context);
  const std::size_t window = 2 * static_cast<std::size_t>(ThreadCount(options.threads)) + 2;
  ParallelOrdered<FinishedBlock>(
      count, options.threads, window,
      [&](std::size_t i) {
        if (stop || progress.IsCancelled()) {
          FinishedBlock skipped;
          skipped.error = Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
          return skipped;
        }
        const RenderBlock& block = context.plan.blocks[i];
        const BlockGeometry geometry = GeometryOf(context, block);
        if (memory == nullptr) return FinishBlock(context, options, block, geometry);
        const Digest digest =
            DigestBlock(context, options.encode, memory->photo_digests, block, geometry, steps);
        FinishedBlock finished;
        const std::optional<Digest> earlier = memory->map.DigestOf(block.tile);
        finished.is_kept = earlier == digest;
        if (earlier && !finished.is_kept && options.encode.encoding == image::TileEncoding::kJpegWebp) {
          const pyramid::EncodeOptions with_png{image::TileEncoding::kJpegPng, options.encode.quality};
          finished.has_png_fringe =
              earlier == DigestBlock(context, with_png, memory->photo_digests, block, geometry, steps);
          finished.is_kept = finished.has_png_fringe;
        }
        if (!finished.is_kept) finished = FinishBlock(context, options, block, geometry);
        finished.digest = digest;
        return finished;
      },
      [&](std::size_t i, FinishedBlock&& block) {
        for (const std::uint32_t photo : last_shown[i]) context.cache.Drop(photo);
        if (failure) return;
        if (block.error) {
          failure = block.error;
          stop = true;
          return;
        }
        Result<pyramid::KeptBlock> kept =
            TakeOver(context.plan, context.plan.blocks[i].tile, block, options.encode, memory, put);
        if (!kept) {
          failure = kept.error();
          stop = true;
        }
        if (failure) return;
        if (block.is_kept) {
          report.tiles += kept->tiles;
          ++report.blocks_kept;
        }
        if (block.is_kept && !kept->topmost.empty()) {
          auto half = pyramid::HalfOfTile(kept->topmost, context.plan.tile_size_px);
          if (!half) {
            failure = half.error();
            stop = true;
            return;
          }
          block.half = *std::move(half);
        }
        if (block.half) overviews.AddHalf(context.plan.blocks[i].tile, *block.half);
        report.base_tiles += kept->base_tiles;
        report.covered_m2 += CoveredM2(*kept, pixel_m);
        report.covered_in_merc.Include(kept->covered_in_merc);
        progress.Report(static_cast<double>(i + 1) / static_cast<double>(count),
                        fmt::format("block {} of {}", i + 1, count));
      });
  if (!failure) overviews.Finish();
  if (failure) return *failure;
  report.blocks = static_cast<std::int64_t>(count);
  return report;
}

}  // namespace skyquilt::render
