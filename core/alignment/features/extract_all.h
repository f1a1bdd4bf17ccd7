// ExtractAll: the features of every photo of a flight, in parallel. A photo that cannot be decoded costs its
// features, not the flight: the reason stands in its place. Same result for any number of threads.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/alignment/features/features.h"
#include "core/alignment/scene/keypoints.h"
#include "core/base/progress.h"
#include "core/flight/photos/photo_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct Photographed {
  std::vector<PhotoFeatures> features;  // by photo
  std::vector<std::string> unreadable;  // a reason a photo; empty: it was read

  // Null where the photo could not be read.
  std::vector<const PhotoFeatures*> Readable() const;
};

// By the photo's name, where an earlier decode of the photo found them.
using FoundFeatures = std::map<std::string, PhotoFeatures>;

// Takes what was found with the same options. Reports progress up to `last_fraction`; stops early, with what
// there is, when it is cancelled.
Photographed ExtractAll(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                        const FeatureOptions& options, FoundFeatures found, int threads, double last_fraction,
                        Progress& progress);

}  // namespace skyquilt::alignment
