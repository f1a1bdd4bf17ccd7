#include "core/pipeline/memory_budget.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel_for.h"
#include "core/geo/web_mercator.h"
#include "core/render/seams/seam_grid.h"

namespace skyquilt::pipeline {
namespace {

// Measured with tests/bench/memory.py at several budgets.
constexpr std::int64_t kMib = std::int64_t{1} << 20;
constexpr std::int64_t kProgramBytes = 130 * kMib;
constexpr std::int64_t kMinCacheBytes = 48 * kMib;
constexpr std::int64_t kThreadBytes = 22 * kMib;  // beside its block

}  // namespace

render::PlanOptions PlanWithin(const MosaicOptions& options) {
  render::PlanOptions plan;
  plan.gsd_m = options.gsd_m;
  plan.not_finer_than_photos = options.not_finer_than_photos;
  if (options.boundary) plan.boundary = &*options.boundary;
  plan.max_block_bytes = options.max_memory_bytes - kProgramBytes - kMinCacheBytes - kThreadBytes;
  plan.max_seam_bytes = options.max_memory_bytes / 2;
  return plan;
}

RenderBudget BudgetFor(const MosaicOptions& options, const render::MosaicPlan& plan) {
  const std::int64_t left =
      options.max_memory_bytes - kProgramBytes - kMinCacheBytes - render::OverviewBytes(plan);
  const std::int64_t a_thread = kThreadBytes + render::BlockBytes(plan.BlockSizePx());
  RenderBudget budget;
  budget.threads =
      static_cast<int>(std::clamp<std::int64_t>(left / a_thread, 1, ThreadCount(options.threads)));
  budget.cache_bytes = kMinCacheBytes + std::max<std::int64_t>(0, left - budget.threads * a_thread);
  return budget;
}

std::int64_t MostDecodeBytes(const MosaicOptions& options) {
  return std::max(kMinCacheBytes, (options.max_memory_bytes - kProgramBytes) / ThreadCount(options.threads));
}

std::int64_t ForetoldBytes(const MosaicOptions& options, const render::MosaicPlan& plan,
                           const FlightSize& size) {
  constexpr std::int64_t kStartedBytes = 75 * kMib;
  constexpr std::int64_t kComparedPixels = 1'500'000;  // of a photo, whatever its size
  constexpr std::int64_t kBytesPerComparedPixel = 25;
  constexpr std::int64_t kFeatureBytes = 1024 * 1024;  // features, matches and what is adjusted, of a photo
  const RenderBudget budget = BudgetFor(options, plan);
  const std::int64_t checked =
      5 * kMib + kBytesPerComparedPixel * std::min(size.largest_pixels, kComparedPixels) +
      3 * std::min(size.largest_pixels, std::max(4 * kComparedPixels, size.largest_pixels / 4));
  const auto blocks = static_cast<std::int64_t>(plan.blocks.size());
  const std::int64_t rendered =
      std::min<std::int64_t>(budget.threads, blocks) * render::BlockBytes(plan.BlockSizePx()) +
      render::OverviewBytes(plan);
  // The photos around the blocks in work: along the curve about so many are not yet done with.
  const auto in_work = std::min<std::int64_t>(
      size.photos, 4 + std::llround(1.5 * std::sqrt(static_cast<double>(size.photos))));
  const std::int64_t decoded = std::min(budget.cache_bytes, 3 * in_work * size.photo_pixels);
  double cells = 0.0;
  const double cell_m =
      render::MakeSeamGrid(
          plan, std::sqrt(static_cast<double>(size.photo_pixels) * 4.0 / 3.0),
          geo::GroundMetresPerMercMetre(
              geo::LatLonFromMerc(0.5 * (plan.bounds_in_merc.min + plan.bounds_in_merc.max)).lat_deg))
          .CellInMercM();
  for (const geo::Bounds2& seen : plan.seen_in_merc) {
    if (!seen.IsEmpty()) cells += seen.Width() * seen.Height() / (cell_m * cell_m);
  }
  return kStartedBytes + ThreadCount(options.threads) * checked + rendered + decoded +
         size.photos * kFeatureBytes + static_cast<std::int64_t>(cells) * render::kSeamCellBytes;
}

}  // namespace skyquilt::pipeline
