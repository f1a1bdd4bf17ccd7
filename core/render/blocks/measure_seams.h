// SeamPatches: how far the two photos that meet at a seam disagree about where things are, measured in their
// pixels after the map has been planned: patches half-way between neighbouring photos are projected to the
// ground from both and shifted against each other by phase correlation (Kuglin and Hines, 1975). A shift
// counts only if the patches look alike once it is undone; grass in the wind and water are left out so. Looks
// at no more than 120 photos, spread over the flight. Same result on any number of threads.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/base/progress.h"
#include "core/ground/ground_surface.h"
#include "core/render/blocks/photo_cache.h"
#include "core/render/seams/seam_shift.h"

namespace skyquilt::render {

struct MeasureSeamsOptions {
  int threads = 0;
  // Of the map: photos are asked of the cache at the scale that it was rendered from.
  double output_pixel_m = 0.0;
};

class SeamPatches {
 public:
  // The flight must outlive it.
  SeamPatches(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
              const MeasureSeamsOptions& options);
  ~SeamPatches();

  // Tells a cache what Measure will ask it for, and takes it as it comes by, so that no photo has to be
  // decoded again or kept for Measure alone. This must outlive the cache's last Get.
  void WatchFor(PhotoCache& cache);
  SeamShift Measure(PhotoCache& cache, Progress& progress);

 private:
  struct InBoth;
  void Project(std::size_t photo, int denominator, const image::DecodedPart& decoded);

  const alignment::AlignedFlight& flight_;
  const MeasureSeamsOptions options_;
  std::vector<int> denominators_;  // by photo
  std::vector<InBoth> patches_;
  std::vector<std::vector<std::size_t>> patches_of_;  // by photo
};

}  // namespace skyquilt::render
