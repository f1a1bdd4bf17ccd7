// MeasureTargets: by which factor each band's values are wrong where the ground's reflectance is known. A
// target is looked at in the captures that stand nearest above it, each band in its own picture; the median
// of what they show counts. Blocking; one thread; decodes up to six pictures a target and band. Never fails:
// a target that no capture shows, or that is overexposed or uneven, is said in the warnings.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/captures.h"
#include "core/flight/photos/photo_source.h"
#include "core/flight/remarks/remark.h"
#include "core/ground/ground_surface.h"
#include "core/render/bands/band_cameras.h"

namespace skyquilt::render {

struct TargetFactors {
  std::vector<std::vector<double>> by_band;  // of captures.bands; one a target that says something of it
  std::vector<flight::Remark> warnings;
};

TargetFactors MeasureTargets(const alignment::AlignedFlight& references, const ground::GroundSurface& ground,
                             const bands::Captures& captures, const BandCameras& cameras,
                             const flight::PhotoSource& source);

}  // namespace skyquilt::render
