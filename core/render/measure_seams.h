// MeasureSeams: how far the two photos that meet at a seam disagree about where things are, measured in their
// pixels after the map has been planned: patches half-way between neighbouring photos are laid on the ground
// from both and shifted against each other by phase correlation (Kuglin and Hines, 1975). A shift counts only
// if the patches look alike once it is undone; grass in the wind and water are left out so. Looks at no more
// than 120 photos, spread over the flight. Same result on any number of threads.
#pragma once

#include <cstdint>
#include <string>

#include "core/alignment/aligned_flight.h"
#include "core/base/progress.h"
#include "core/ground/ground_surface.h"
#include "core/render/photo_cache.h"

namespace skyquilt::render {

struct MeasureSeamsOptions {
  int threads = 0;
  int most_pairs = 60;
  double output_pixel_m =
      0.0;  // of the map: photos are asked of the cache at the scale that it was rendered from
};

struct SeamShift {
  int patches = 0;   // looked at
  int reliable = 0;  // of those: alike once shifted
  double gsd_m = 0.0;
  double median_m = 0.0;
  double p90_m = 0.0;
};

SeamShift MeasureSeams(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       PhotoCache& cache, const MeasureSeamsOptions& options, Progress& progress);

std::string SeamShiftJson(const SeamShift& shift);

}  // namespace skyquilt::render
