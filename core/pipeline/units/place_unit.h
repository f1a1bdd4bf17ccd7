// PlaceUnit: the whole flight from what was found in its photos up to the decision on which photo shows what,
// as the facts from which any process renders part of the map. Decodes no photo but those that nobody has
// looked at. Blocking. Memory: as BuildMosaic up to there, about 0.7 MB for each photo. Errors: as
// BuildMosaic.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/geo/dem_source.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/mosaic_report.h"
#include "core/pipeline/units/found_photos.h"
#include "core/pipeline/units/shown_photos.h"

namespace skyquilt::pipeline {

struct PlacedUnit {
  std::string facts;  // as WriteFacts has them, with the appearance of the map
  ShownPhotos shown;
  std::size_t blocks = 0;
  std::vector<StageTiming> timings;
};

Result<PlacedUnit> PlaceFound(const std::vector<flight::InputFile>& files, FoundFiles found,
                              const MosaicOptions& options, const flight::PhotoSource& source,
                              const geo::DemSource* dem, Progress& progress);

}  // namespace skyquilt::pipeline
