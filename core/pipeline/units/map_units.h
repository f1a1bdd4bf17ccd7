// The two units of a flight that make its map: PlaceFound places it, from what was found in its photos, and
// RenderRange, in any process, renders a range of the map's blocks by the facts that come of it. Blocking;
// the result does not depend on threads nor on where a range begins and ends. Errors: those of BuildMosaic;
// kCorrupt (bytes of another unit), kInvalidArgument (a range that the map does not have), those of decoding
// and of the sink, kCancelled.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/photos/photo_source.h"
#include "core/geo/dem_source.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/plan_map.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/pipeline/units/flight_cut.h"
#include "core/pyramid/map_memory.h"
#include "core/pyramid/tile_sink.h"

namespace skyquilt::pipeline {

// Which photos each block of a planned map may show, so that whoever renders a range of blocks fetches no
// others. Written as CBOR (RFC 8949) by whoever placed the flight.
struct ShownPhotos {
  std::vector<std::string> names;                     // of all placed photos
  std::vector<std::vector<std::uint32_t>> of_blocks;  // indices of `names`, rising

  // Of a range of blocks; what lies beyond the last block shows nothing.
  std::set<std::string> NamesIn(const UnitRange& blocks) const;
};

// `planned`: of the whole map.
ShownPhotos FindShown(const FlightFacts& facts, const PlannedMap& planned);

std::string WriteShown(const ShownPhotos& shown);
Result<ShownPhotos> ParseShown(std::string_view bytes);

struct PlacedUnit {
  std::string facts;  // as WriteFacts has them, with the appearance of the map
  ShownPhotos shown;
  std::size_t blocks = 0;
  std::vector<StageTiming> timings;
};

// The whole flight up to the decision on which photo shows what. Decodes no photo but those that nobody has
// looked at. Memory: as BuildMosaic up to there, about 0.7 MB for each photo.
Result<PlacedUnit> PlaceFound(const std::vector<flight::InputFile>& files, FoundFiles found,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              const geo::DemSource* dem, Progress& progress);

struct RenderedUnit {
  std::int64_t tiles = 0;
  int min_zoom = 0;  // of these tiles
  int max_zoom = 0;
  int tile_size_px = 256;
  std::vector<StageTiming> timings;
};

// The range's tiles into a memory from which BuildMosaic takes them over; overviews above the blocks are made
// there, once. Reads the photos that the range shows, and no others. `files`: at least those of these photos.
// `sink` and `memory`: of this range alone.
Result<RenderedUnit> RenderRange(std::string_view facts, const UnitRange& blocks,
                                 const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                 const flight::PhotoSource& source, pyramid::TileSink& sink,
                                 pyramid::MapMemory& memory, Progress& progress);

}  // namespace skyquilt::pipeline
