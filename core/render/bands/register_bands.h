// RegisterBands: how the other bands of each capture lie on its reference band, which is placed. From the
// recorded lenses and the reference's pose, coarse to fine: patches of the pictures are found in each other
// (band_patches), a rotation and a shift are fitted per capture and a lens per camera (fit_band_cameras). A
// capture over ground without any edges, or one whose patches put a band apart from where it lies in all
// others, takes its usual stand. Parallel over captures; the result does not depend on threads. Memory: four
// pictures a thread. Blocking. A picture that cannot be decoded is left out and said in the warnings; the
// only error is kCancelled.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/bands/captures.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/ground/ground_surface.h"
#include "core/render/bands/band_cameras.h"

namespace skyquilt::render {

struct RegisterOptions {
  int threads = 0;
  std::int64_t max_bytes = std::int64_t{512} << 20;  // for pictures; one thread works in any case
};

// `references`: the captures' references alone, each as it was placed.
Result<BandCameras> RegisterBands(const alignment::AlignedFlight& references,
                                  const ground::GroundSurface& ground, const bands::Captures& captures,
                                  const flight::PhotoSource& source, const RegisterOptions& options,
                                  Progress& progress);

}  // namespace skyquilt::render
