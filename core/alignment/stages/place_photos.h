// PlacePhotos: from the adjusted bundle to the flight the map is made of: which photos count as aligned,
// where the others go, how far off each may be, and the tie points worth modelling the ground from. Pure; any
// thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/bundle/bundle_adjustment.h"
#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/stages/doubt_photos.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

struct PlaceInput {
  const poses::PosedFlight* posed = nullptr;
  const BundleProblem* problem = nullptr;
  const std::vector<Track>* ground_tracks = nullptr;  // with points that agree with the adjusted poses
  const std::vector<CorrectedPose>* corrected = nullptr;
  const std::vector<PhotoDoubt>* doubts = nullptr;
  const std::vector<std::string>* unreadable = nullptr;  // a reason a photo; empty: it was read
};

// Fills the report's photos, components and residuals.
AlignedFlight PlacePhotos(const PlaceInput& input, AlignReport& report);

}  // namespace skyquilt::alignment
