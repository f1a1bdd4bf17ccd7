// What the stages of an alignment hand on: ExtractedFlight, what each photo of a flight shows beside what it
// records, and Attempt, one alignment of it as far as it has come. Values; any thread.
#pragma once

#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/features/features.h"
#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/view.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct ExtractedFlight {
  ExtractedFlight() = default;
  ExtractedFlight(ExtractedFlight&&) = default;  // not copied: `readable` points into it
  ExtractedFlight& operator=(ExtractedFlight&&) = default;

  poses::PosedFlight posed;  // in frame enu; with poses that stand for none where no record places a photo
  std::vector<PhotoRecord> records;            // by photo, with what they claim to be good for
  std::vector<int> lines;                      // by photo: the flight line it was taken on
  std::vector<PhotoFeatures> features;         // by photo
  std::vector<GyroReport> gyros;               // by camera with a gyro: how its clock was tied to the rows
  std::vector<const PhotoFeatures*> readable;  // into `features`; null where a photo could not be read
};

struct Attempt {
  poses::PosedFlight posed;  // where the photos were taken to be before they were compared
  MatchedFlight matched;
  std::vector<PhotoPair> compared;  // by the first passes, whatever came of it
  Relief relief{0.0};
  BundleProblem problem;
  BundleSummary adjusted;  // by the last adjustment
  bool is_adjusted = false;
  // As far as it has come: what was tried without the records, surveyed points once it is tied to them,
  // records of all photos that were corrected (heights not believed, positions that were late), costs.
  AlignReport report;
};

}  // namespace skyquilt::alignment
