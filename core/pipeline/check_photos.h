// CheckPhotos: decodes every photo once, small: what is damaged is found before anything is placed, the small
// pictures serve the exposure model, and the features, where they are asked for, the alignment. Parallel; the
// result does not depend on threads. Memory: about 60 kB per photo, 0.4 MB with features.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/alignment/features/features.h"
#include "core/base/progress.h"
#include "core/flight/flight.h"
#include "core/flight/photos/photo_source.h"
#include "core/render/thumbnail.h"

namespace skyquilt::pipeline {

// What one decode of a photo gave.
struct CheckedPhoto {
  render::Thumbnail thumbnail;
  std::optional<alignment::PhotoFeatures> features;  // where they were asked for and it is large enough
};
using CheckedPhotos = std::map<std::string, CheckedPhoto>;  // by name

struct CheckedFlight {
  flight::Flight flight;                      // without the damaged photos, which are in left_out
  std::vector<render::Thumbnail> thumbnails;  // one per photo
  alignment::FoundFeatures features;
};

// `known`: photos that another process checked with the same options; they are not decoded again.
Result<CheckedFlight> CheckPhotos(flight::Flight flight, const flight::PhotoSource& source,
                                  const std::optional<alignment::FeatureOptions>& features, int threads,
                                  Progress& progress, CheckedPhotos known = {});

}  // namespace skyquilt::pipeline
