// FoundPhotos: what was found in a flight's photos by decoding each of them once: its thumbnail, its features
// and the digest of its file, for whoever places the flight in another process. By the name of the file: a
// flight of which two files share a name is not cut into units. Written as CBOR (RFC 8949). Values; any
// thread. Errors: of FindInPhotos kCancelled; of ParseFound kCorrupt.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/digest.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/photos/photo_source.h"
#include "core/pipeline/check_photos.h"
#include "core/pipeline/mosaic_options.h"

namespace skyquilt::pipeline {

struct FoundFiles {
  std::map<std::string, Digest> digests;  // by name, also of files that are no photos
  CheckedPhotos photos;                   // by name
};

// A file that is no photo, or a damaged one, has a digest alone: whoever reads the whole flight says what is
// wrong with it.
Result<FoundFiles> FindInPhotos(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const flight::PhotoSource& source, Progress& progress);

std::string WriteFound(const FoundFiles& found);
// Adds to what is there.
Result<void> ParseFound(std::string_view bytes, FoundFiles& found);

}  // namespace skyquilt::pipeline
