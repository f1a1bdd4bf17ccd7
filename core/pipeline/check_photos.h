// What decoding each photo of a flight once, small, gives. CheckPhotos does so for a whole flight: what is
// damaged is found before anything is placed, the small pictures serve the exposure model, and the features,
// where they are asked for, the alignment. FindInPhotos does so for some of the files, whose outcome goes as
// CBOR (RFC 8949) to whoever places the flight in another process. Parallel; the result does not depend on
// threads. Memory: about 60 kB per photo, 0.4 MB with features. Errors: kCancelled; of ParseFound kCorrupt.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/alignment/features/features.h"
#include "core/base/digest.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/flight.h"
#include "core/flight/photos/photo_source.h"
#include "core/pipeline/mosaic_options.h"
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
                                  bool with_features, int threads, Progress& progress,
                                  CheckedPhotos known = {});

// By the name of the file: a flight of which two files share a name is not cut into units.
struct FoundFiles {
  std::map<std::string, Digest> digests;  // also of files that are no photos
  CheckedPhotos photos;
};

// A file that is no photo, or a damaged one, has a digest alone: whoever reads the whole flight says what is
// wrong with it.
Result<FoundFiles> FindInPhotos(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const flight::PhotoSource& source, Progress& progress);

std::string WriteFound(const FoundFiles& found);
// Adds to what is there.
Result<void> ParseFound(std::string_view bytes, FoundFiles& found);

}  // namespace skyquilt::pipeline
