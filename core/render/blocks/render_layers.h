// RenderLayers: the pyramids of a finished map's layers, block by block straight into their sinks, at a
// quarter of the map's resolution or so (a block of the map is one tile). No photo is decoded. Colours are
// never averaged: a coarser tile shows every other pixel. The same bytes in the same order with any number of
// threads. Blocking. Errors: those of the sinks; kCancelled.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/ground/ground_surface.h"
#include "core/pyramid/tile_sink.h"
#include "core/render/map_layer.h"
#include "core/render/mosaic_plan.h"
#include "core/render/seams/seam_map.h"

namespace skyquilt::render {

struct LayerSink {
  MapLayer layer;
  pyramid::TileSink& sink;
};

struct LayerZooms {
  int min_zoom = 0;
  int max_zoom = 0;
};

LayerZooms ZoomsOfLayers(const MosaicPlan& plan);

// Gives what the heights of the covered ground lie between; zeros without the layer of heights. `raised_m` is
// added to all heights. `known`: of which photos the errors are coloured.
Result<HeightRange> RenderLayers(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                                 const SeamMap& seams, const MosaicPlan& plan,
                                 const std::vector<LayerSink>& layers, int threads, Progress& progress,
                                 double raised_m = 0.0,
                                 alignment::ErrorsKnown known = alignment::ErrorsKnown::kOfAll);

}  // namespace skyquilt::render
