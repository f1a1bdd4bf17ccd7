// PlaceFlight: the first half of the flow: from files to placed photos and the ground below them; with a
// memory of an earlier run as little of it as has changed: the same files are not compared again, and a few
// photos more are placed against the others, or the finished map is brought to where options.placing says
// (and aligned anew where it is to go to surveyed points that it fits only when it is bent). Blocking.
// Errors: as BuildMosaic.
#pragma once

#include <optional>
#include <vector>

#include "core/bands/captures.h"
#include "core/flight/photos/photo_source.h"
#include "core/flight/read_flight.h"
#include "core/geo/dem_source.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pipeline/stage_runner.h"
#include "core/pyramid/map_memory.h"

namespace skyquilt::pipeline {

struct PlacedFlight {
  FlightFacts facts;            // `appearance` is an earlier run's: of its photos, which come first
  std::vector<Digest> digests;  // of the photos' files; only with a memory
  // What a map pixel showed before the map was placed, in today's metres; nothing otherwise.
  std::optional<double> gsd_m;
  bands::Captures captures;  // of cameras of several bands: facts.flight has their references
};

// `found`: of the files that another process has looked at.
Result<PlacedFlight> PlaceFlight(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                 const flight::PhotoSource& source, const geo::DemSource* dem,
                                 const pyramid::MapMemory* memory, StageRunner& stages, Progress& progress,
                                 FoundFiles found = {});

// What photos show may place them where no record does: their features are found when they are decoded for
// the first time. Elsewhere thumbnails suffice.
bool MayGoByImages(const MosaicOptions& options);

}  // namespace skyquilt::pipeline
