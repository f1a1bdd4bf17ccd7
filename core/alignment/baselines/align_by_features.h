// AlignByFeatures: the map of a feature-based pipeline that knows nothing of poses, Iz and Unel's baseline,
// for comparison: homographies chained from photo to photo (ChainHomographies), each component placed on the
// recorded positions at the end by one similarity, so that it can be drawn and measured. A photo that no
// other one matches is left out with the reason, as such pipelines do. Each homography is drawn by the camera
// nearest to it; what no camera could have seen (shear) is lost and stands in the photo's reason. Errors:
// kCancelled, kUnprocessable (no two photos match).
#pragma once

#include "core/alignment/align_flight.h"

namespace skyquilt::alignment {

Result<AlignedFlight> AlignByFeatures(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                      const AlignOptions& options, AlignReport& report, Progress& progress);

}  // namespace skyquilt::alignment
