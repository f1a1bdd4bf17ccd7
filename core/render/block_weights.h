// Which photo owns which pixel of a block, and how neighbours blend across the seam. Every weight is a function of
// the pixel's ground point alone, so it is the same in whatever block or thread it is computed.
// The photo whose camera stood most nearly above the point wins; towards its own border a photo gives way. Any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/aligned_flight.h"
#include "core/render/block_geometry.h"

namespace skyquilt::render {

// The share of one photo in a rectangle of the block.
struct PhotoShare {
  std::uint32_t photo = 0;  // index in the flight
  int x = 0, y = 0, width = 0, height = 0;
  std::vector<float> weight;  // row by row; the shares of all photos at a covered pixel add up to 1
};

struct WeighOptions {
  double feather_m = 0.5;
};

// views[i] belongs to photos[i]; photos are indices into the flight, rising.
std::vector<PhotoShare> WeighPhotos(const alignment::AlignedFlight& flight, const std::vector<std::uint32_t>& photos,
                                    const std::vector<PhotoView>& views, const BlockGeometry& block,
                                    const WeighOptions& options);

}  // namespace skyquilt::render
