#include "core/render/bands/render_bands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/web_mercator.h"
#include "core/render/bands/band_cache.h"
#include "core/render/blocks/block_geometry.h"
#include "core/render/blocks/render_block.h"
#include "core/render/blocks/weigh_block.h"

namespace skyquilt::render {
namespace {

// Where the blocks lie in the world; the other side of the date line is next door.
struct BlockPlace {
  std::int64_t column = 0;
  std::int64_t row = 0;
};
std::vector<BlockPlace> PlacesOf(const MosaicPlan& plan) {
  std::vector<BlockPlace> places;
  for (const RenderBlock& block : plan.blocks) {
    const std::int64_t side = std::int64_t{1} << block.tile.z();
    std::int64_t column = block.tile.x();
    if (!places.empty()) {
      const std::int64_t away = column - places.front().column;
      column -= side * std::llround(static_cast<double>(away) / static_cast<double>(side));
    }
    places.push_back({column, block.tile.y()});
  }
  return places;
}

// The pixels of one photo on one square of a block, bilinear between the nodes around it.
class SquarePixels {
 public:
  SquarePixels(const PhotoView& view, const BlockGeometry& geometry, int x, int y, int denominator)
      : scale_(1.0F / static_cast<float>(denominator)),
        step_px_(geometry.node_step_px),
        left_(x / step_px_ * step_px_),
        top_(y / step_px_ * step_px_) {
    const std::size_t nw = static_cast<std::size_t>(y / step_px_) * geometry.nodes_per_side +
                           static_cast<std::size_t>(x / step_px_);
    const auto row = static_cast<std::size_t>(geometry.nodes_per_side);
    nw_ = view.pixel_in_image[nw], ne_ = view.pixel_in_image[nw + 1];
    sw_ = view.pixel_in_image[nw + row], se_ = view.pixel_in_image[nw + row + 1];
  }
  // In the decoded picture; not a number where the photo does not see.
  Eigen::Vector2f At(int x, int y) const {
    const auto per_px = 1.0F / static_cast<float>(step_px_);
    const float u = static_cast<float>(x - left_) * per_px, v = static_cast<float>(y - top_) * per_px;
    const Eigen::Vector2f north = nw_ + u * (ne_ - nw_), south = sw_ + u * (se_ - sw_);
    const Eigen::Vector2f full = north + v * (south - north);
    return (full.array() + 0.5F) * scale_ - 0.5F;  // centres carry the half pixel
  }

 private:
  const float scale_;
  const int step_px_, left_, top_;
  Eigen::Vector2f nw_, ne_, sw_, se_;
};

// One band of a block.
Result<std::vector<float>> BandOfBlock(const BandsContext& context, std::size_t band,
                                       const WeighedBlock& weighed, const BlockBoundary& boundary,
                                       double pixel_m, BandCache& cache) {
  const int size_px = weighed.geometry.size_px, side = weighed.shares.square_px;
  const std::size_t pixels = static_cast<std::size_t>(size_px) * size_px;
  std::vector<float> sums(pixels, 0.0F), weights(pixels, 0.0F);
  for (const PhotoShare& share : weighed.shares.photos) {
    const std::optional<BandCamera>& camera = context.cameras.captures[share.photo].cameras[band];
    if (!camera || share.squares.empty()) continue;
    PhotoView view = ViewBlock(camera->photo, weighed.geometry);
    for (Eigen::Vector2f& pixel : view.pixel_in_image)
      pixel += camera->field.At(pixel.cast<double>()).cast<float>();
    const int denominator = DenominatorFor(camera->photo, pixel_m);
    SKYQUILT_TRY_ASSIGN(const auto picture, cache.Get(share.photo, *camera, denominator));
    // A part of a square: of one cell of nodes.
    const auto add_part = [&](const SquareShare& square, int left, int top, int part_px) {
      const SquarePixels in_photo(view, weighed.geometry, left, top, denominator);
      for (int y = top; y < top + part_px; ++y) {
        for (int x = left; x < left + part_px; ++x) {
          const float share_of_pixel = share.WeightAt(square, x, y, side);
          if (!(share_of_pixel > 0.0F) || !boundary.Holds(x, y)) continue;
          const Eigen::Vector2f at = in_photo.At(x, y);
          const float value = ValueAt(*picture, at.x(), at.y());
          if (std::isnan(value)) continue;
          const std::size_t pixel = static_cast<std::size_t>(y) * size_px + static_cast<std::size_t>(x);
          sums[pixel] += share_of_pixel * value;
          weights[pixel] += share_of_pixel;
        }
      }
    };
    const int part_px = std::min(side, weighed.geometry.node_step_px);
    for (const SquareShare& square : share.squares) {
      for (int y = square.y; y < square.y + side; y += part_px) {
        for (int x = square.x; x < square.x + side; x += part_px) add_part(square, x, y, part_px);
      }
    }
  }
  constexpr float kMinWeight = 1e-3F;
  for (std::size_t i = 0; i < pixels; ++i)
    sums[i] = weights[i] > kMinWeight ? sums[i] / weights[i] : std::numeric_limits<float>::quiet_NaN();
  return sums;
}

// `places` become those in the raster. Error: kUnprocessable (fields far apart: files of all that lies
// between them take hours and a disk).
Result<bands::BandRaster> RasterOf(const BandsContext& context, std::vector<BlockPlace>& places) {
  bands::BandRaster raster;
  std::int64_t west = places.front().column, east = west, north = places.front().row, south = north;
  for (const BlockPlace& place : places) {
    west = std::min(west, place.column), east = std::max(east, place.column);
    north = std::min(north, place.row), south = std::max(south, place.row);
  }
  for (BlockPlace& place : places) place.column -= west, place.row -= north;
  const MosaicPlan& plan = context.plan;
  constexpr double kMaxSpannedPixels = 1e11, kMaxEmptyTimes = 16.0;
  const double spanned = static_cast<double>(east - west + 1) * static_cast<double>(south - north + 1);
  if (spanned > kMaxEmptyTimes * static_cast<double>(places.size()) &&
      spanned * plan.BlockSizePx() * plan.BlockSizePx() > kMaxSpannedPixels)
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFieldsFarApart);
  const double block_m = geo::TileSizeInMercM(plan.base_zoom - plan.block_levels);
  raster.west_in_merc_m = static_cast<double>(west) * block_m - geo::kMercHalfWidthM;
  raster.north_in_merc_m = geo::kMercHalfWidthM - static_cast<double>(north) * block_m;
  raster.block_px = plan.BlockSizePx();
  raster.pixel_in_merc_m = block_m / raster.block_px;
  raster.width_px = static_cast<int>((east - west + 1) * raster.block_px);
  raster.height_px = static_cast<int>((south - north + 1) * raster.block_px);
  for (const bands::Band& band : context.captures.bands) {
    raster.bands.push_back({band.name, band.wavelength_nm.value_or(0.0), band.width_nm.value_or(0.0),
                            bands::CalibrationName(band.calibration), band.method});
  }
  return raster;
}

}  // namespace

std::int64_t BandBlockBytes(const MosaicPlan& plan, std::size_t bands) {
  const std::int64_t pixels = std::int64_t{plan.BlockSizePx()} * plan.BlockSizePx();
  constexpr std::int64_t kSumAndWeight = 8, kWeighed = 12;
  return pixels * (kSumAndWeight * static_cast<std::int64_t>(bands) + kWeighed);
}

Result<void> RenderBands(const BandsContext& context, const flight::PhotoSource& source,
                         const RenderBandsOptions& options, bands::BandSink& sink, Progress& progress) {
  const MosaicPlan& plan = context.plan;
  std::vector<BlockPlace> places = PlacesOf(plan);
  SKYQUILT_TRY_ASSIGN(const bands::BandRaster raster, RasterOf(context, places));
  SKYQUILT_TRY(sink.Begin(raster));
  const std::size_t bands = context.captures.bands.size();
  std::vector<BandCache> caches(
      bands,
      BandCache(source, options.cache_bytes / static_cast<std::int64_t>(std::max<std::size_t>(1, bands))));
  const double pixel_m = OutputPixelM(plan, context.references);
  for (std::size_t i = 0; i < plan.blocks.size(); ++i) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
    const RenderBlock& block = plan.blocks[i];
    const WeighedBlock weighed = WeighBlock(
        context.references, context.ground, context.seams, plan, block,
        MakeBlockGeometry(block.tile, plan.BlockSizePx(), context.references.frame, context.ground));
    progress.Report(static_cast<double>(i) / static_cast<double>(plan.blocks.size()),
                    fmt::format("bands of block {} of {}", i + 1, plan.blocks.size()));
    if (weighed.shares.photos.empty()) continue;
    const BlockBoundary boundary(plan, block.tile);
    std::vector<Result<std::vector<float>>> made(bands, std::vector<float>());
    // A band has its own cache: no two threads ask for one picture.
    ParallelFor(bands, options.threads, [&](std::size_t band) {
      made[band] = BandOfBlock(context, band, weighed, boundary, pixel_m, caches[band]);
    });
    std::vector<std::vector<float>> values;
    for (Result<std::vector<float>>& of_band : made) {
      if (!of_band) return of_band.error();
      values.push_back(*std::move(of_band));
    }
    SKYQUILT_TRY(sink.Put(static_cast<int>(places[i].column * raster.block_px),
                          static_cast<int>(places[i].row * raster.block_px), values));
  }
  return {};
}

}  // namespace skyquilt::render
