// How --max-memory is divided, and what a flight will take of it. Beside the budget a map may take what no
// option moves: the libraries and what each thread compares photos with (256 MiB), and each photo's features
// (2 MiB per photo). Pure; any thread.
#pragma once

#include <cstdint>

#include "core/pipeline/mosaic_options.h"
#include "core/render/mosaic_plan.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {

// How large blocks may be and how many cells the seams may have.
render::PlanOptions PlanWithin(const MosaicOptions& options);

struct RenderBudget {
  int threads = 1;               // that may render blocks at a time
  std::int64_t cache_bytes = 0;  // for decoded photos
};
RenderBudget BudgetFor(const MosaicOptions& options, const render::MosaicPlan& plan);

// What decoding one photo may take beside the picture that comes out, where every thread decodes one.
std::int64_t MostDecodeBytes(const MosaicOptions& options);

struct FlightSize {
  std::int64_t photos = 0;
  std::int64_t photo_pixels = 0;    // of a photo, typical
  std::int64_t largest_pixels = 0;  // of the largest
};
// An upper bound of the peak, within a factor of about two; tests/e2e/command_line/memory_prediction_test.py
// holds it against the real one.
std::int64_t ForetoldBytes(const MosaicOptions& options, const render::MosaicPlan& plan,
                           const FlightSize& size);

}  // namespace skyquilt::pipeline
