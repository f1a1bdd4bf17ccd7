// CheckPhotos: decodes every photo once, small: what is damaged is found before anything is placed, and the small
// pictures serve the exposure model. Parallel; the result does not depend on threads. Memory: about 60 kB a photo.
#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/flight/flight.h"
#include "core/pipeline/ports.h"
#include "core/render/thumbnail.h"

namespace skyquilt::pipeline {

struct CheckedFlight {
  flight::Flight flight;                       // without the damaged photos, which are in left_out
  std::vector<render::Thumbnail> thumbnails;   // one a photo
};

Result<CheckedFlight> CheckPhotos(flight::Flight flight, const PhotoSource& source, int threads, Progress& progress);

}  // namespace skyquilt::pipeline
