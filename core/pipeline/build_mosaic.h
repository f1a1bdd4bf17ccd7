// BuildMosaic: the whole flow, photos and logs in, tiles out, one stage after the other. Blocking; uses all
// the threads asked for. A photo that cannot be read, decoded or placed is left out and listed; it never
// fails the map. Errors: kUnprocessable (nothing could be placed), kCancelled, those of the sink.
#pragma once

#include <optional>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/flight/read_flight.h"
#include "core/geo/dem_source.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/build_bands.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/pipeline/surface/map_surface.h"
#include "core/pyramid/map_memory.h"
#include "core/pyramid/tile_sink.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::pipeline {

struct BuiltMosaic {
  alignment::AlignedFlight flight;
  ground::GroundSurface ground;
  render::MosaicPlan plan;
  render::SeamMap seams;
  std::optional<MapSurface> surface;  // where things stand upright: what the photos are laid on
  std::optional<BandedMap> bands;     // what bands.tif is built from; nothing for photos in colour
  MosaicReport report;

  const ground::GroundSurface& ShownGround() const { return surface ? surface->ground : ground; }
};

// `dem`: heights of the ground where known; may be null. `memory`: what earlier runs left of this map; may be
// null. With it blocks of which nothing has changed are not rendered again; the map is the same as without.
// `found`: of the files that another process has looked at.
Result<BuiltMosaic> BuildMosaic(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const flight::PhotoSource& photo_source, pyramid::TileSink& sink,
                                Progress& progress, const geo::DemSource* dem = nullptr,
                                pyramid::MapMemory* memory = nullptr, FoundFiles found = {});

}  // namespace skyquilt::pipeline
