// RenderBands: a raster with all bands of a flight, block by block straight into the sink: which capture
// shows what comes from the references' seam map, where each band shows it from its own camera, so that the
// bands of a pixel are of one place and one moment. Values are calibrated and never evened out; where
// captures meet they blend over the seams' width. Memory: a block's values and the decoded pictures, within
// the budget. The same values with any number of threads. Blocking. Errors: those of the sink and of decoding
// what could be decoded while the bands were registered; kUnprocessable (fields far apart); kCancelled.
#pragma once

#include <cstdint>

#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/band_sink.h"
#include "core/base/progress.h"
#include "core/flight/photos/photo_source.h"
#include "core/ground/ground_surface.h"
#include "core/render/bands/band_cameras.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

struct RenderBandsOptions {
  int threads = 0;
  std::int64_t cache_bytes = std::int64_t{256} << 20;
};

struct BandsContext {
  const alignment::AlignedFlight& references;
  const ground::GroundSurface& ground;
  const SeamMap& seams;
  const MosaicPlan& plan;
  const BandCameras& cameras;
  const bands::Captures& captures;
};

// What a block takes while it is rendered.
std::int64_t BandBlockBytes(const MosaicPlan& plan, std::size_t bands);

Result<void> RenderBands(const BandsContext& context, const flight::PhotoSource& source,
                         const RenderBandsOptions& options, bands::BandSink& sink, Progress& progress);

}  // namespace skyquilt::render
