// libFuzzer: plan and seams of flights and pictures of any kind. Checked: every cell that a photo sees is
// shown by a photo that sees it, and the plan's size is bounded.
#include <algorithm>

#include "core/base/check.h"
#include "core/render/blocks/weigh_block.h"
#include "core/render/plan_mosaic.h"
#include "core/render/seams/seam_map.h"
#include "tests/fuzz/core/flight_from_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  fuzz::Bytes bytes(data, size);
  const alignment::AlignedFlight flight = fuzz::PlausibleFlightFrom(bytes);
  const auto ground = ground::GroundSurface::Plane(bytes.Below(4) == 0 ? 5.0 : 0.0);
  auto plan = render::PlanMosaic(flight, ground, {});
  if (!plan) {
    SKYQUILT_CHECK(plan.error().message.size() > 20, "a refusal without a reason");
    return 0;
  }
  SKYQUILT_CHECK(plan->tile_size_px <= 4096, "tiles without bounds");
  plan->max_seam_cells = std::min<std::int64_t>(plan->max_seam_cells, 1 << 16);  // more only take longer
  const auto thumbnails = fuzz::ThumbnailsFrom(bytes, flight);
  const render::ExposureModel exposure = render::ExposureModel::Even(flight.photos.size());
  render::SeamOptions options;
  options.threads = 1;
  const render::SeamMap seams = render::BuildSeamMap(flight, ground, *plan, exposure, thumbnails, options);
  for (int row = 0; row < seams.grid.rows; row += 1 + seams.grid.rows / 100) {
    for (int column = 0; column < seams.grid.columns; column += 1 + seams.grid.columns / 100) {
      const std::int32_t label = seams.labels.At(column, row);
      SKYQUILT_CHECK(label < static_cast<std::int32_t>(flight.photos.size()), "a label of no photo");
      for (const render::PhotoLevels& levels : seams.levels)
        SKYQUILT_CHECK(label >= 0 || !levels.SeesWhole(column, row), "a cell that is seen and not shown");
    }
  }
  SKYQUILT_CHECK(render::ShownRegions(flight, ground, seams).size() == flight.photos.size(),
                 "a photo too few");
  return 0;
}
