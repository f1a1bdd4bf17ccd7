// ExposureSamples: the brightness of the same spots of ground as different photos show it. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

struct ExposureSample {
  std::uint32_t spot = 0;  // which spot of ground
  std::uint32_t photo = 0;
  std::array<float, 2> ground_m{};  // east and north, in enu
  std::array<float, 2> place{};     // in the image, as Shade has it
  std::array<float, 2> look{};      // as LookOf has it
  std::array<float, 3> log_value{};
};

// Sorted by spot, then photo; only spots seen by two photos or more, and no clipped or black values.
std::vector<ExposureSample> SampleExposure(const alignment::AlignedFlight& flight,
                                           const ground::GroundSurface& ground,
                                           const std::vector<Thumbnail>& thumbnails);

// One past the samples of the spot that begins there.
std::size_t EndOfSpot(const std::vector<ExposureSample>& samples, std::size_t begin);

}  // namespace skyquilt::render
