// MeasureSeams: how far the two photos that meet at a seam disagree about where things are, measured in their
// pixels after the map has been planned: patches half-way between neighbouring photos are laid on the ground
// from both and shifted against each other by phase correlation (Kuglin and Hines, 1975). A shift counts only
// if the patches look alike once it is undone; grass in the wind and water are left out so. Decodes at most
// 120 photos at half size, spread over the flight. Same result on any number of threads.
#pragma once

#include <cstdint>
#include <string>

#include "core/alignment/aligned_flight.h"
#include "core/base/progress.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/ports.h"

namespace skyquilt::render {

struct MeasureSeamsOptions {
  int threads = 0;
  int most_pairs = 60;
  std::int64_t budget_bytes = std::int64_t{256} << 20;  // for decoded photos
};

struct SeamShift {
  int patches = 0;   // looked at
  int reliable = 0;  // of those: alike once shifted
  double gsd_m = 0.0;
  double median_m = 0.0;
  double p90_m = 0.0;
};

SeamShift MeasureSeams(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                       const pipeline::PhotoSource& source, const MeasureSeamsOptions& options,
                       Progress& progress);

std::string SeamShiftJson(const SeamShift& shift);

}  // namespace skyquilt::render
