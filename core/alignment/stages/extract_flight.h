// ExtractFlight: what each photo of a flight shows (features) beside what it records, before any photo is
// compared with another. Photos that no record places take part, in the order of capture.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/features/features.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/stages/align_options.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct ExtractedFlight {
  ExtractedFlight() = default;
  ExtractedFlight(ExtractedFlight&&) = default;  // not copied: `readable` points into it
  ExtractedFlight& operator=(ExtractedFlight&&) = default;

  poses::PosedFlight posed;  // in frame enu; with poses that stand for none where no record places a photo
  std::vector<PhotoRecord> records;  // by photo
  std::vector<int> lines;            // by photo: the flight line it was taken on
  Photographed photographed;
  std::vector<GyroReport> gyros;               // by camera with a gyro: how its clock was tied to the rows
  std::vector<const PhotoFeatures*> readable;  // into `photographed`; null where a photo could not be read

  std::vector<std::string> Names() const;
};

Error AlignmentCancelled();

// Errors: kCancelled.
Result<ExtractedFlight> ExtractFlight(const poses::PosedFlight& recorded, const flight::PhotoSource& source,
                                      const AlignOptions& options, FoundFeatures found, Progress& progress);

}  // namespace skyquilt::alignment
