// RenderUnit: the tiles of a range of the map's blocks, by the facts of a flight that another process placed,
// into a memory from which BuildMosaic takes them over. Overviews above the blocks are made there, once.
// Reads the photos that the range shows, and no others. Blocking; the result does not depend on threads nor
// on where the range begins and ends. Errors: kCorrupt (the facts), kInvalidArgument (a range that the map
// does not have), those of decoding and of the sink, kCancelled.
#pragma once

#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/photos/photo_source.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/pyramid/map_memory.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::pipeline {

struct RenderedUnit {
  std::int64_t tiles = 0;
  int min_zoom = 0;  // of these tiles
  int max_zoom = 0;
  int tile_size_px = 256;
  std::vector<StageTiming> timings;
};

// `files`: at least those of the photos that the range shows. `sink` and `memory`: of this range alone.
Result<RenderedUnit> RenderRange(std::string_view facts, const UnitRange& blocks,
                                 const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                 const flight::PhotoSource& source, pyramid::TileSink& sink,
                                 pyramid::MapMemory& memory, Progress& progress);

}  // namespace skyquilt::pipeline
